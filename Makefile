# Everything works in an environment of its own, .venv; nothing is installed outside it but what tests need of Debian's.
PYTHON ?= python3
BIN := .venv/bin
DEBIAN := poppler-utils ghostscript chromium default-jre-headless libpdfbox2-java libcommons-logging-java \
	libbcprov-java libactivation-java libjaxb-api-java
PREFLIGHT := /usr/share/java/preflight.jar

.PHONY: plate test soak bench gallery page clean

plate: .venv/installed
	$(BIN)/crowquill stipple gallery/specimen.png plate.pdf plate.svg --pen 0.3mm --paper a4 --check-bar

test: .venv/tested tools-for-tests
	$(BIN)/python -m pytest -m "not soak"

soak: .venv/tested tools-for-tests
	$(BIN)/python -m pytest -m soak

# Rows, and a page of plots, in bench/out; QUICK=1 takes three minutes, all of it half an hour.
bench: .venv/tested
	$(BIN)/python bench/bench.py $(if $(QUICK),quick)
	$(if $(QUICK),,$(BIN)/python bench/batch.py)

gallery: .venv/tested
	for script in gallery/*.py; do $(BIN)/python $$script || exit 1; done

# The editor's page from its sources in web; users need neither Node nor this.
page: web/node_modules/made
	npm run --prefix web --silent types
	npm run --prefix web --silent build

web/node_modules/made: web/package-lock.json
	npm ci --prefix web --silent --no-fund --no-audit
	touch $@

.venv/made:
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "crowquill takes Python 3.11 or newer; say which: make PYTHON=python3.12")'
	$(PYTHON) -m venv .venv
	touch $@

.venv/installed: pyproject.toml | .venv/made
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[editor]'
	touch $@

.venv/tested: pyproject.toml | .venv/made
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[test]'
	touch $@ .venv/installed

# Renderers that tests measure with. Where they cannot be installed, the tests that need them are reported as not run.
.PHONY: tools-for-tests
tools-for-tests:
	@command -v npm >/dev/null && $(MAKE) --silent web/node_modules/made || echo "NOT INSTALLED: Node's packages; tests of the page's sources will be reported as not run"
	@[ $$(command -v pdftoppm gs chromium java | wc -l) = 4 ] && [ -e $(PREFLIGHT) ] \
	|| { [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null && apt-get update -qq && \
	     DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $(DEBIAN) >/dev/null; } \
	|| echo "NOT INSTALLED: some of $(DEBIAN); tests that render with them will be reported as not run"

clean:
	rm -rf .venv plate.pdf plate.svg
