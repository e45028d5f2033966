"""The editor: a drawing's marks moved, inserted, deleted and relaxed by hand, every change an operation in a log.

`drawing` is the state, `operations` all that changes it, `log` and `history` what was done, `states` what need not be done again,
`session` all of them together on a file; `hub` and `server` show it to pages, by PROTOCOL.md.

Source: O. Deussen, S. Hiller, C. van Overveld, T. Strothotte, Floating Points, Eurographics 2000, for brushes on dots and relaxation in
steps; S. Hiller, H. Hellwig, O. Deussen, Beyond Stippling, Computer Graphics Forum 22(3), 2003, for objects and mosaics.
"""
