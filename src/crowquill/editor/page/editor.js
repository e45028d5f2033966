"use strict";(()=>{var P=class{listeners=new Set;on(e){this.listeners.add(e)}say(e){for(let t of[...this.listeners])t(e)}},L=class{constructor(e){this.now=e}now;changed=new P;get value(){
return this.now}set value(e){Object.is(e,this.now)||(this.now=e,this.changed.say(e))}on(e){e(this.now),this.changed.on(e)}};function V(r,e){
let t=`crowquill ${r}`,n=new L(e);try{let i=JSON.parse(localStorage.getItem(t)??"null");typeof i==typeof e&&(n.value=i)}catch{}return n.on(i=>{
try{localStorage.setItem(t,JSON.stringify(i))}catch{}}),n}var Jt=.5,re=class{theme=V("theme","system");under=V("under","picture");instead=new L(null);opacity=V("opacity",.25);rulers=V("rulers",!0);guides=V(
"guides",!0);keys=V("keys",!0);changed=new P;colours=new Map;constructor(){let e=matchMedia("(prefers-color-scheme: dark)"),t=()=>{let n=this.
theme.value==="dark"||this.theme.value==="system"&&e.matches;document.documentElement.dataset.theme=n?"dark":"light",this.colours.clear(),this.
changed.say()};this.theme.on(t),e.addEventListener("change",t);for(let n of[this.under,this.instead,this.opacity,this.rulers,this.guides])n.
on(()=>this.changed.say())}flip(){this.theme.value=document.documentElement.dataset.theme==="dark"?"light":"dark"}colour(e){let t=this.colours.
get(e);return t||this.colours.set(e,t=getComputedStyle(document.documentElement).getPropertyValue(`--${e}`).trim()),t}get look(){let{instead:e,
under:t,opacity:n}=this,i={selected:Ae(this.colour("selected")),frozen:Ae(this.colour("frozen")),lines:Ae(this.colour("lines"))};return{...{
desk:this.colour("desk"),paper:"#fff",tints:i,under:e.value??t.value},opacity:e.value?Math.max(n.value,Jt):n.value}}};function Ae(r){let e=parseInt(
r.slice(1),16);return[e>>16&255,e>>8&255,e&255]}function m(r,e={},...t){let n=document.createElement(r);return B(n,e),n.append(...t.filter(i=>i!=null&&i!==!1)),n}function B(r,e){for(let[t,
n]of Object.entries(e))typeof n=="function"?r.addEventListener(t,n):n==null||n===!1?r.removeAttribute(t):r.setAttribute(t,n===!0?"":String(n))}
function ie(r,e){r.textContent!==e&&(r.textContent=e)}var qt=0;function x(r){return`${r}-${++qt}`}function w(r){let e=document.getElementById(
r);if(!e)throw new Error(`the page has no element ${r}`);return e}function j(r){let e=document.createElementNS("http://www.w3.org/2000/svg",
"svg");B(e,{viewBox:"0 0 16 16",class:"icon","aria-hidden":"true"});let t=document.createElementNS("http://www.w3.org/2000/svg","path");return B(
t,{d:r}),e.append(t),e}function z(r,e,t,n={}){return m("button",{type:"button",class:"icon-button","aria-label":e,title:e,click:t,...n},j(r))}
function M(r,e,t={}){return m("button",{type:"button",click:e,...t},r)}var A=(r,e,t)=>`M${r-t} ${e}a${t} ${t} 0 1 0 ${2*t} 0a${t} ${t} 0 1 0 ${-2*t} 0`,C={pick:"M4 2.5 12.5 8 8.7 8.9 6.6 12.6Z",rectangle:"M2.5 5\
.5v-2h2M11.5 3.5h2v2M13.5 10.5v2h-2M4.500 12.500h-2v-2M7 3.500h2M7 12.500h2M2.500 7.300v1.400M13.500 7.300v1.400",lasso:"M8 3c3.500 0 5.800 \
1.500 5.800 3.600S11.500 10 8 10 2.300 8.700 2.300 6.600 4.500 3 8 3ZM5.300 9.600c-1 .6-1 2 .2 2.200s1.700-.8 1-1.900M5.500 11.800c.4 1 .2 1\
.700-.5 2","select brush":`${A(8,8,5.5)}M8 5.500v5M5.500 8h5`,insert:`${A(4,11.5,1.5)}${A(9.5,12,1)}${A(6.5,6.5,1)}M12 2.500v6M9 5.500h6`,erase:"\
M6 13.500 2.500 10 9.500 3 13.500 7 7 13.500ZM6 6.500l4 4M7 13.500h7",push:"M2.500 8h9M8.500 4.500 12 8l-3.500 3.500M14 3v10",attract:`${A(8,
8,1.6)}M8 1.500v3M8 11.500v3M1.500 8h3M11.500 8h3M3.400 3.400l2 2M10.600 10.600l2 2M12.600 3.400l-2 2M5.400 10.600l-2 2`,jitter:`${A(4,4.5,1)}${A(
11.5,3.5,1)}${A(7.5,8,1)}${A(3.5,12,1)}${A(12.5,11.5,1)}M9.500 6.500l1.500-1M5.700 9.500l-1 1M9.500 9.300l1.400 1`,resize:`${A(4.5,10.5,1.5)}${A(
10,7,3.5)}`,turn:"M13 8a5 5 0 1 1-1.700-3.700M11.500 1.500v3h-3",swap:"M2.500 5.500h9L9 3M13.500 10.500h-9L7 13",freeze:"M8 1.500v13M2.400 4\
.750l11.200 6.500M13.600 4.750 2.400 11.250M6 2.700 8 4.500l2-1.800M6 13.300l2-1.800 2 1.800",paint:"M9.500 8.500 13.500 2.500M9.700 8.300c1\
.500 1.500 0 5.200-6.700 5.200 1.700-1 1.500-2 2-3.500.6-1.900 3.300-3 4.700-1.700Z",relax:`${A(4,4,1.1)}${A(12,4,1.1)}${A(8,8,1.1)}${A(4,12,
1.1)}${A(12,12,1.1)}`,wall:"M3 3.500 10 2.500 13.500 8 10.500 13 3.500 11.500Z",region:"M2.500 4h11M2.500 8h7M2.500 12h4M12 9.500v5M9.500 12\
h5",pan:"M8 1.800v12.400M1.800 8h12.400M6 3.800l2-2 2 2M6 12.200l2 2 2-2M3.800 6l-2 2 2 2M12.200 6l2 2-2 2",undo:"M6 3 2.500 6.500 6 10M2.50\
0 6.500H10a3.500 3.500 0 0 1 0 7H7",redo:"M10 3l3.500 3.500L10 10M13.500 6.500H6a3.500 3.500 0 0 0 0 7h3",shown:"M1.500 8S4 3.500 8 3.500 14\
.500 8 14.500 8 12 12.500 8 12.500 1.500 8 1.500 8ZM8 6.200a1.800 1.800 0 1 0 0 3.600 1.800 1.800 0 0 0 0-3.600",hidden:"M1.500 8S4 12 8 12s\
6.500-4 6.500-4M4 11l-1 2M8 12v2M12 11l1 2",locked:"M4 7.500h8v6H4ZM5.500 7.500V5a2.500 2.500 0 0 1 5 0v2.500",open:"M4 7.500h8v6H4ZM5.500 7\
.500V5a2.500 2.500 0 0 1 4.900-.8",up:"M8 13V3M4 7l4-4 4 4",down:"M8 3v10M4 9l4 4 4-4",add:"M8 3v10M3 8h10",remove:"M3 4.500h10M6 4.500V3h4v\
1.500M4.500 4.500l.5 9h6l.5-9",take:"M8 2v7M5 6.500 8 9.500l3-3M3 11v2.500h10V11",play:"M5 3l8 5-8 5Z",pause:"M5.500 3v10M10.500 3v10",stop:"\
M4 4h8v8H4Z",step:"M4 3l6 5-6 5ZM12.500 3v10",file:"M4 2h5.500L13 5.500V14H4ZM9 2v4h4",export:"M8 10V2M5 4.500 8 1.500l3 3M3 9v5h10V9",help:"\
M5.500 6a2.500 2.500 0 1 1 3.600 2.200C8.200 8.700 8 9.200 8 10M8 12.600v.3",theme:`${A(8,8,3)}M8 1v1.500M8 13.500V15M1 8h1.500M13.500 8H15M\
3 3l1 1M12 12l1 1M13 3l-1 1M4 12l-1 1`,cancel:"M4 4l8 8M12 4l-8 8",fit:"M2.500 6V2.500H6M10 2.500h3.500V6M13.500 10v3.500H10M6 13.500H2.500V\
10"};function Z(r,...e){let t=x("dialog"),n=()=>o.close(),i=m("header",{},m("h2",{id:t},r),z(C.cancel,"Close",n)),o=m("dialog",{"aria-labelledby":t},
i,m("div",{class:"dialog-body"},...e)),s=document.activeElement;return o.addEventListener("close",()=>{o.remove(),s instanceof HTMLElement&&
s.focus()}),o.addEventListener("click",a=>a.target===o&&n()),document.body.append(o),o.showModal(),o}var oe=1e3,Xt=15,Qt=1e5,_t=100;function se(r,e,t,n={}){return r.name==="glyph"?ln(r,e,t,n):r.kind==="flag"?tn(r,e,t):r.kind==="choice"?nn(r,
e,t):r.kind==="range"?rn(r,e,t):an(r,e,t)}var Qe={pdfx:"PDF/X",pdfa:"PDF/A",icc:"ICC profile",dpi:"DPI"},en={paper:["a4","a5","letter"]};function $(r){
if(Qe[r])return Qe[r];let e=r.replace(/_/g," ");return e.charAt(0).toUpperCase()+e.slice(1)}function ae(r,e,...t){let n=m("label",{for:e,title:r.
help},$(r.name));return m("div",{class:"knob"},n,m("div",{class:"knob-inputs"},...t))}function tn(r,e,t){let n=x("knob"),i=m("input",{type:"\
checkbox",id:n,change:()=>t(i.checked)}),o=m("div",{class:"knob knob-flag"},i,m("label",{for:n,title:r.help},$(r.name)));return _(o,e,s=>i.checked=
s===!0)}function nn(r,e,t){let n=x("knob"),i=r.names??[],o=r.default===null?[m("option",{value:""},"automatic")]:[],s=m("select",{id:n,title:r.
help,change:()=>t(s.value||null)},...o,...i.map(a=>m("option",{value:a},a)));return _(ae(r,n,s),e,a=>s.value=a===null?"":String(a))}function rn(r,e,t){
let n=x("knob"),[i,o]=[r.low??0,r.high??1],s=on(i,o,typeof r.default=="number"?r.default:null,r.unit),a=r.whole?1:"any",l=m("input",{type:"n\
umber",id:n,class:o>=Qt?"long":null,min:i,max:o,step:a,title:r.help,placeholder:r.default===null?"auto":null}),c=m("input",{type:"range",min:0,
max:oe,tabindex:-1,"aria-hidden":"true",title:r.help}),u=d=>{l.setCustomValidity(""),t(d)};l.addEventListener("input",()=>{if(l.value===""&&
!l.validity.badInput)return t(r.default);l.validity.valid&&(c.value=String(s.to(l.valueAsNumber)*oe),u(l.valueAsNumber))}),c.addEventListener(
"input",()=>{let d=sn(s.from(Number(c.value)/oe),r.whole??!1);l.value=String(d),u(d)});let h=r.unit?m("span",{class:"unit"},r.unit==="deg"?"\
°":r.unit):null;return _(ae(r,n,c,l,h),e,d=>{document.activeElement!==l&&(l.value=typeof d=="number"?String(d):""),c.value=String(s.to(typeof d==
"number"?d:i)*oe)})}function on(r,e,t,n){let i=Math.max(Math.abs(t??0),r,1e-6);if(e<=1||(e-r)/i<Xt)return{to:c=>(c-r)/(e-r),from:c=>r+c*(e-r)};
let o=n==="mm"?Math.min(e,_t):e,s=Math.max(.001,Math.min(t?Math.abs(t):o,o/5)/3),[a,l]=[Math.asinh(r/s),Math.asinh(o/s)];return{to:c=>Math.min(
1,(Math.asinh(c/s)-a)/(l-a)),from:c=>s*Math.sinh(a+c*(l-a))}}function sn(r,e){return e?Math.round(r):Math.abs(r)<.001?0:Number(r.toPrecision(
2))}function an(r,e,t){let n=x("knob"),i=r.kind==="numbers",o=en[r.name]?.map(l=>m("option",{value:l}))??[],s=o.length?m("datalist",{id:x("k\
nown")},...o):null,a=m("input",{type:"text",id:n,title:r.help,spellcheck:"false",placeholder:r.default===null?"auto":null,list:s?.id});return a.
addEventListener("change",()=>{let l=a.value.trim(),c=l.split(/[\s,;]+/).map(Number),u=i&&l!==""&&(c.some(Number.isNaN)||r.count!=null&&c.length!==
r.count);a.setCustomValidity(u?`${r.count??"Some"} numbers, parted by commas`:""),u?a.reportValidity():t(l===""?r.default:i?c:l)}),_(ae(r,n,
a,s),e,l=>a.value=l===null?"":Array.isArray(l)?l.join(", "):String(l))}function ln(r,e,t,n){let i=x("knob"),o=r.default===null?[m("option",{
value:""},"as the layer has")]:[],s=m("select",{id:i,title:r.help},...o,...Object.keys(n).map(h=>m("option",{value:h},h))),a=m("div",{class:"\
shapes",role:"group","aria-label":"Shapes of the library"}),l=h=>{let[d="",p]=typeof h=="string"?h.split("/"):[];s.value=d,a.replaceChildren(
...(n[d]??[]).map((f,g)=>c(d,g,f,String(g)===p))),a.hidden=!d},c=(h,d,p,f)=>{let g=()=>{let v=f?h:`${h}/${d}`;t(v),l(v),a.children[d]?.focus()};
return m("button",{type:"button","aria-pressed":String(f),"aria-label":`${h} ${d}`,click:g},cn(p))};s.addEventListener("change",()=>{t(s.value||
null),l(s.value||null)});let u=m("div",{},ae(r,i,s),a);return _(u,e,l)}function cn(r){let e=document.createElementNS("http://www.w3.org/2000\
/svg","svg"),t=document.createElementNS("http://www.w3.org/2000/svg","path");return e.setAttribute("viewBox",[-1,-1,2,2].map(n=>1e3*n*r.reach).
join(" ")),e.classList.toggle("lines",!r.closed),e.setAttribute("aria-hidden","true"),t.setAttribute("d",r.d),e.append(t),e}function _(r,e,t){
return t(e),{element:r,show:t}}var un=/\.(pdf|svg)$/,hn=["svg","pdf"];function Pe(r){let e=r.drawing.hello.value;if(!e)return;let t=m("input",{type:"text",id:x("export"),value:`${e.
name.replace(/\.[^.]*$/,"")}-edited`,required:!0,spellcheck:"false"}),n=new Map,i=m("div",{class:"knobs"}),o=Object.keys(e.formats).map(d=>{
let p=m("input",{type:"checkbox",id:x("format"),value:d,checked:hn.includes(d),change:()=>a()});return{format:d,box:p,element:m("span",{class:"\
chip"},p,m("label",{for:p.id},d))}}),s=()=>o.filter(d=>d.box.checked).map(d=>d.format),a=()=>i.replaceChildren(..._e(e,s()).map(d=>se(d,n.get(
d.name)??d.default,p=>n.set(d.name,p)).element)),l=m("input",{type:"checkbox",id:x("over")}),c=m("div",{"aria-live":"polite"}),u=M("Export",
()=>{h()},{class:"wide primary"}),h=async()=>{if(!t.reportValidity()||!s().length)return;let d=new Set(_e(e,s()).map(v=>v.name)),p=Object.fromEntries(
[...n].filter(([v,y])=>d.has(v)&&y!==null)),f=s().map(v=>`${t.value}.${v}`),g=await et(u,"Writing…",tt(r,c,{do:"export",files:f,options:p,
overwrite:l.checked}));g&&c.replaceChildren(...(g.files??[]).map(v=>mn(r,v)))};a(),Z("Export",m("div",{class:"knob"},m("label",{for:t.id},"N\
ame"),m("div",{class:"knob-inputs"},t)),m("div",{class:"row chips",role:"group","aria-label":"Formats"},...o.map(d=>d.element)),m("details",
{},m("summary",{},"Options of these formats"),i),m("div",{class:"knob knob-flag"},l,m("label",{for:l.id},"Replace files that are there")),u,
c)}function _e(r,e){let t=new Map;for(let n of e)for(let i of r.formats[n]??[])t.has(i.name)||t.set(i.name,i);return[...t.values()]}async function et(r,e,t){
let n=r.textContent;r.disabled=!0,r.textContent=e;let i=await t;return r.disabled=!1,r.textContent=n,i}async function tt(r,e,t){try{return(await r.
link.ask(t)).facts}catch(n){return e.replaceChildren(m("p",{class:"error"},n.message)),null}}function mn(r,e){let t=m("div",{}),n=async()=>{
let o=await et(i,"Checking…",tt(r,t,{do:"check",file:e}));o&&t.replaceChildren(dn(o.findings??[]))},i=un.test(e)?M("Preflight",()=>{n()}):
null;return m("div",{class:"written"},m("p",{},m("strong",{},e)," is written"),i,t)}function dn(r){return r.length?m("ul",{class:"findings"},
...r.map(e=>m("li",{class:e.severity},m("strong",{},e.severity),` ${e.message} `,m("small",{},e.where)))):m("p",{},"Nothing stands between i\
t and the press.")}function pn(r){let e=r.key.length===1?r.key.toLowerCase():r.key,t=/^[a-z]$/.test(e)||r.key.length>1;return[...[(r.ctrlKey||r.metaKey)&&"Ctrl",
r.altKey&&"Alt",r.shiftKey&&t&&"Shift"].filter(Boolean),e].join("+")}var fn="input:not([type=checkbox]):not([type=radio]):not([type=range]),\
 select, textarea",Ie=new Map,rt;function it(r,e){Ie.size||window.addEventListener("keydown",gn),rt=e,Ie=new Map(r.flatMap(t=>t.keys.map(n=>[
n,t])))}function gn(r){let e=pn(r),t=Ie.get(e);!t||e.length===1&&!rt.value||r.defaultPrevented||document.querySelector("dialog[open]")||r.target instanceof
Element&&r.target.matches(fn)||(r.preventDefault(),t.run(e))}var nt=[["Wheel","Pan; with Ctrl, or two fingers, zoom"],["Space and drag","Pan\
; so does the middle button"],["Alt and a brush","The other way round: smaller, turned back, thawed"],["Shift, Alt and a selection","Add to \
it, take from it"],["Arrows on the canvas","Move the pointer by 1 mm, with Shift by 10"],["Enter on the canvas","Press the tool where the po\
inter is"]];function ot(r,e){let t=e.map(s=>[s.shown??s.keys.slice(0,2).map(bn).join(" or "),s.about]),n=Math.ceil(t.length/2+nt.length/2),i=m(
"p",{class:"help"},`crowquill ${r.drawing.hello.value?.version??""}`),o=m("div",{class:"stack"},Ce("More keys",t.slice(n)),Ce("Pointer and p\
en",nt),i);Z("Keys",m("div",{class:"help-sheet"},Ce("Keys",t.slice(0,n)),o)).classList.add("wide-dialog")}function Ce(r,e){let t=e.map(([n,i])=>m(
"tr",{},m("th",{scope:"row"},m("kbd",{},n)),m("td",{},i)));return m("table",{},m("caption",{},r),m("tbody",{},...t))}function bn(r){return r.
split(/\+(?=.)/).map(e=>e.length===1?e.toUpperCase():e).join(" ")}async function De(r){let e=await r.ask({do:"files"});if(!e)return;let t=e.facts.files??[],n=async s=>{o.close(),await r.ask({do:"open",file:s})&&
r.messages.note(`${s} is open; every tab shows it.`)},i=m("ul",{class:"files"},...t.map(s=>m("li",{},M(s,()=>{n(s)})))),o=Z("Open",t.length?
i:m("p",{},"There is nothing else in the folder that can be opened."))}var vn=96/25.4;function st(r,e){let t=()=>[...yn(r),...wn(r),...Mn(r),...kn(r),...xn(r,e,n)],n=()=>ot(r,t());r.tools.on(o=>{o.length&&it(t(),
r.appearance.keys)});let i=[["undo",()=>{r.ask({do:"undo"})}],["redo",()=>{r.ask({do:"redo"})}],["open",()=>{De(r)}],["export",()=>Pe(r)],["\
theme",()=>r.appearance.flip()],["help",n],["fit",()=>r.viewport.all()],["zoom",()=>r.viewport.set(vn*r.viewport.ratio)]];for(let[o,s]of i)w(
o).addEventListener("click",s),w(o).classList.contains("icon-button")&&w(o).replaceChildren(j(C[o]));r.drawing.state.on(o=>{for(let[s,a,l,c]of[
["undo",o?.undo,"Undo","Ctrl Z"],["redo",o?.redo,"Do again","Ctrl Shift Z"]]){w(s).disabled=!a?.length;let u=`${l}${a?.[0]?`: ${a[0]}`:""} (${c}\
)`;w(s).title!==u&&(w(s).title=u)}})}function yn(r){return r.tools.value.filter(t=>t.key).map(t=>({keys:[t.key],about:t.title,run:()=>r.tool.
value=t}))}function wn(r){let e=()=>!!r.drawing.state.value?.selected,t=i=>()=>{r.apply("select",{by:i})},n=i=>()=>{let o=r.operation("relax");
o&&r.apply("relax",{...r.settings.params(o),...r.ofLayer(o)},{times:i})};return[{keys:["Ctrl+z"],about:"Undo",run:()=>{r.ask({do:"undo"})}},
{keys:["Ctrl+Shift+z","Ctrl+y"],about:"Do again",run:()=>{r.ask({do:"redo"})}},{keys:["Ctrl+a"],about:"Select all",run:t("all")},{keys:["Ctr\
l+i"],about:"Invert the selection",run:t("invert")},{keys:["Ctrl+d"],about:"Duplicate the selection",run:()=>{e()&&r.apply("duplicate",{})}},
{keys:["Delete","Backspace"],about:"Erase the selection",run:()=>{e()&&r.apply("erase",{on:"selection"})}},{keys:["x"],about:"One step of re\
laxation",run:n(1)},{keys:["Shift+x"],about:"Ten steps of relaxation",run:n(10)}]}function Mn(r){let{settings:e}=r,t=i=>()=>{let o=r.tool.value?.
operation;o&&e.scale(o,"size",i)},n=i=>{let o=r.tool.value?.operation;o&&e.set(o,"strength",i==="0"?1:Number(i)/10)};return[{keys:["["],about:"\
Smaller brush",run:t(1/1.2)},{keys:["]"],about:"Larger brush",run:t(1.2)},{keys:[..."1234567890"],shown:"1 … 9, 0",about:"Strength 10 … 90\
, 100 %",run:n}]}function kn(r){let{viewport:e}=r;return[{keys:["+","="],about:"Closer",run:()=>e.zoom(1.25)},{keys:["-"],about:"Farther",run:()=>e.
zoom(1/1.25)},{keys:["Home"],about:"The whole paper",run:()=>e.all()},{keys:["z"],about:"What is selected, as large as it goes",run:()=>{let n=r.
drawing.selection();n&&e.fit(n)}}]}function xn(r,e,t){return[{keys:["Escape"],about:"Give up the stroke, stop the work, or select nothing",run:()=>{
let{busy:i,selected:o}=r.drawing.state.value??{};e.busy?e.cancel():i?r.ask({do:"stop"}):r.region.value?r.region.value=null:o&&r.apply("selec\
t",{by:"none"})}},{keys:["Ctrl+o"],about:"Open",run:()=>{De(r)}},{keys:["Ctrl+s"],about:"Export",run:()=>Pe(r)},{keys:["Shift+d"],about:"Lig\
ht or dark",run:()=>r.appearance.flip()},{keys:["?"],about:"This sheet",run:t}]}var le=class{constructor(e,t,n,i,o,s){this.link=e;this.drawing=t;this.settings=n;this.viewport=i;this.messages=o;this.appearance=s}link;drawing;settings;viewport;messages;appearance;layer=new L(
null);tools=new L([]);tool=new L(null);region=new L(null);libraries={};group=0;operation(e){return this.drawing.hello.value?.operations.find(
t=>t.name===e)}newGroup(){return this.group=Math.max(this.group+1,Date.now())}async apply(e,t,n={}){return this.ask({do:"apply",op:e,params:t,
...n})}async ask(e){try{let t=await this.link.ask(e);for(let n of t.notes??[])this.messages.note(n);return t}catch(t){return this.messages.error(
t.message),null}}ofLayer(e){let t=this.layer.value;return t!==null&&e.knobs.some(n=>n.name==="layer")?{layer:t}:{}}};var F=class r{count=0;end=0;layer=new Uint32Array(1024);x=new Int32Array(1024);y=new Int32Array(1024);scale=new Uint32Array(1024);turn=new Uint16Array(
1024);kind=new Uint32Array(1024);fill=new Uint32Array(1024);flags=new Uint8Array(1024);clear(){this.layer.fill(0),this.count=this.end=0}take(e){
let{n:t,ids:n,first:i,x:o,y:s,dx:a,dy:l,scale:c,turn:u,kind:h,fill:d,flags:p}=e;if(t){this.reserve(r.id(e,t-1)+1);for(let f=0;f<t;f++){let g=n?
n[f]:i+f;this.layer[g]&&this.count--,e.gone||this.count++,this.layer[g]=e.gone?0:e.layer}n||(o&&this.x.set(o,i),s&&this.y.set(s,i),c&&this.scale.
set(c,i),u&&this.turn.set(u,i),h&&this.kind.set(h,i),d&&this.fill.set(d,i),p&&this.flags.set(p,i));for(let f=0;f<t&&(n||a);f++){let g=n?n[f]:
i+f;a&&(this.x[g]+=a[f],this.y[g]+=l[f]),n&&(o&&(this.x[g]=o[f]),s&&(this.y[g]=s[f]),c&&(this.scale[g]=c[f]),u&&(this.turn[g]=u[f]),h&&(this.
kind[g]=h[f]),d&&(this.fill[g]=d[f]),p&&(this.flags[g]=p[f]))}}}static id(e,t){return e.ids?e.ids[t]:e.first+t}reserve(e){if(this.end=Math.max(
this.end,e),e<=this.layer.length)return;let t=2**Math.ceil(Math.log2(e));this.layer=I(this.layer,new Uint32Array(t)),this.x=I(this.x,new Int32Array(
t)),this.y=I(this.y,new Int32Array(t)),this.scale=I(this.scale,new Uint32Array(t)),this.turn=I(this.turn,new Uint16Array(t)),this.kind=I(this.
kind,new Uint32Array(t)),this.fill=I(this.fill,new Uint32Array(t)),this.flags=I(this.flags,new Uint8Array(t))}};function I(r,e){return e.set(
r),e}var En=/([a-zA-Z])|(-?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)/g,Tn={M:2,L:2,H:1,V:1,C:6,S:4,Q:4,T:2,Z:0},Ln=1e3,Sn=.04,An=.005,Y=class{constructor(e,t,n){
this.closed=t;this.reach=n;this.paths=Pn(e,t)}closed;reach;paths;flats=new Map;rings(e){let t=Math.max(0,Math.ceil(Math.log2(Math.max(e,1)))),
n=this.flats.get(t);return n||this.flats.set(t,n=this.paths.map(i=>Cn(i,Math.min(An,Sn/2**t)))),n}};function Pn(r,e){let t=[...r.matchAll(En)].
map(c=>c[1]??Number(c[2])/Ln),n=[],i=null,[o,s]=[0,0],a=null,l="";for(let c=0;c<t.length;){typeof t[c]=="string"&&(l=t[c++]);let u=l.toUpperCase(),
h=Tn[u];if(h===void 0)throw new Error(`path data with ${l||"no command"}`);let d=l!==u,p=t.slice(c,c+h);if(c+=h,u==="Z"){i&&([i.closed,[o,s]]=
[!0,i.from]),l=d?"m":"M",a=null;continue}if(d&&u!=="H"&&u!=="V")for(let y=0;y<h;y++)p[y]+=y%2?s:o;if(u==="M"||!i){i={from:[p[0],p[1]],pieces:[],
closed:e},n.push(i),[o,s]=i.from,l=d?"l":"L";continue}let f=(y,T)=>{i.pieces.push({to:[o=y,s=T]}),a=null},g=(y,T,E,k,H,S)=>{i.pieces.push({cubic:[
y,T,E,k,H,S]}),[o,s]=[H,S]},v=a?[2*o-a[0],2*s-a[1]]:[o,s];if(u==="L")f(p[0],p[1]);else if(u==="H")f(d?o+p[0]:p[0],s);else if(u==="V")f(o,d?s+
p[0]:p[0]);else if(u==="C")g(p[0],p[1],p[2],p[3],p[4],p[5]),a=[p[2],p[3]];else if(u==="S")g(v[0],v[1],p[0],p[1],p[2],p[3]),a=[p[0],p[1]];else{
let[y,T]=u==="Q"?[p[0],p[1]]:v,[E,k]=u==="Q"?[p[2],p[3]]:[p[0],p[1]];g(o+2/3*(y-o),s+2/3*(T-s),E+2/3*(y-E),k+2/3*(T-k),E,k),a=[y,T]}}return n}
function Cn(r,e){let t=[...r.from];for(let n of r.pieces){if("to"in n){t.push(...n.to);continue}let[i,o]=[t[t.length-2],t[t.length-1]],[s,a,
l,c,u,h]=n.cubic,d=Math.max(Math.hypot(i-2*s+l,o-2*a+c),Math.hypot(s-2*l+u,a-2*c+h)),p=Math.min(64,Math.max(1,Math.ceil(Math.sqrt(.75*d/e))));
for(let f=1;f<=p;f++){let g=f/p,v=1-g,[y,T,E,k]=[v*v*v,3*v*v*g,3*v*g*g,g*g*g];t.push(y*i+T*s+E*l+k*u,y*o+T*a+E*c+k*h)}}return{xy:Float64Array.
from(t),closed:r.closed}}var In=["tone","importance"],Dn=["cells","axes","flow"],Oe=class{constructor(e){this.buffer=e}buffer;at=0;words(e){return this.taken(new Uint32Array(
this.buffer,this.at,e))}whole(e){return this.taken(new Int32Array(this.buffer,this.at,e))}shorts(e){return this.taken(new Uint16Array(this.buffer,
this.at,e))}steps(e){return this.taken(new Int16Array(this.buffer,this.at,e))}bytes(e){return this.taken(new Uint8Array(this.buffer,this.at,
e))}floats(e){return this.taken(new Float32Array(this.buffer,this.at,e))}taken(e){return this.at+=Math.ceil(e.byteLength/4)*4,e}};function On(r){
let[e,t,n,i]=r.words(4),o={layer:e,gone:(n&-65)===0,n:t,first:i};return n&64||(o.ids=r.words(t)),n&128?(o.dx=r.steps(t),o.dy=r.steps(t)):n&1&&
(o.x=r.whole(t),o.y=r.whole(t)),n&2&&(o.scale=r.words(t)),n&4&&(o.turn=r.shorts(t)),n&8&&(o.kind=r.words(t)),n&16&&(o.fill=r.words(t)),n&32&&
(o.flags=r.bytes(t)),o}function Hn(r){let[e,t,n,i,o,s,a]=r.words(8),l=r.bytes(i*o);return{map:In[e],top:t,left:n,height:i,width:o,rows:s,columns:a,
values:l}}function Rn(r){let[e,t,n,i]=r.words(4);return{what:Dn[e],closed:i!==0,start:r.words(t+1),xy:r.floats(2*n)}}function ce(r){let e=new Oe(
r),[t,n,i]=e.words(4),o=s=>Array.from({length:i},()=>s(e));if(t===1)return{revision:n,type:"items",chunks:o(On)};if(t===2)return{revision:n,
type:"raster",patches:o(Hn)};if(t===3)return{revision:n,type:"lines",lines:Rn(e)};throw new Error(`the server sent a frame of unknown type ${t}`)}var ue=class{constructor(e,t){this.painter=t;e.said.on(n=>{n.say==="hello"&&n.protocol!==1?e.lost.say(`This page speaks protocol ${1}, the s\
erver ${n.protocol}: load the page again.`):n.say==="hello"&&this.begin(n),n.say==="state"&&this.take(n),n.say==="saved"&&(this.saved.value=
n),n.say==="tabs"&&(this.tabs.value=n.count),n.say==="step"&&this.steps.say(n)}),e.frames.on(n=>{try{this.receive(n)}catch(i){e.lost.say(`A \
part of the drawing could not be read (${i.message}); it is asked for again.`),e.ask({do:"refresh"}).catch(()=>{})}}),this.changed.on(()=>this.
around=null)}painter;hello=new L(null);state=new L(null);saved=new L(null);tabs=new L(1);steps=new P;lines=new P;changed=new P;items=new F;kinds=new Map;canvas=[];around=null;missing=0;begun(e){
let t=!1;this.hello.on(n=>{n&&!t&&e(n),t||=n!==null})}selection(){return(this.around??=this.found()).box}found(){let{items:e}=this,t={left:1/0,
top:1/0,right:-1/0,bottom:-1/0};for(let n of this.selected()){let[i,o,s]=[e.x[n]/1e3,e.y[n]/1e3,this.reach(n)];t.left=Math.min(t.left,i-s),t.
top=Math.min(t.top,o-s),t.right=Math.max(t.right,i+s),t.bottom=Math.max(t.bottom,o+s)}return{box:t.left<t.right?t:null}}*selected(){if(!this.
state.value?.selected)return;let{items:e}=this;for(let t=0;t<e.end;t++)e.layer[t]&&e.flags[t]&1&&(yield t)}reach(e){return(this.kinds.get(this.
items.kind[e])?.reach??1)*this.items.scale[e]/1e3}begin(e){this.missing=1,this.painter({do:"begin",size:e.size,art:e.art}),this.hello.value=
e}take(e){e.reset&&(this.items.clear(),this.kinds.clear()),e.canvas&&(this.canvas=e.canvas);for(let s of e.kinds)this.kinds.set(s.id,new Y(s.
d,s.closed,s.reach));let{revision:t,frames:n,layers:i,kinds:o}=e;this.painter({do:"state",revision:t,frames:n,reset:e.reset??!1,layers:i,kinds:o}),
this.missing=e.frames,this.state.value=e,this.missing||this.changed.say()}receive(e){let t=ce(e);if(t.type==="items")for(let n of t.chunks)this.
items.take(n);this.painter({do:"frame",buffer:e},[e]),t.type==="lines"?this.lines.say(t.lines.what):--this.missing===0&&this.changed.say()}};function lt(r){let e=m("ol",{class:"history","aria-label":"Changes, the latest first"}),t="";return r.drawing.state.on(n=>{if(!n)return;let i=JSON.
stringify([n.undo,n.redo]);if(i===t)return;t=i;let o=(c,u)=>{r.ask({do:c,count:u})},s=n.redo.map((c,u)=>m("li",{class:"undone"},M(c,()=>o("r\
edo",u+1),{title:"Do again up to here"}))),a=n.undo.map((c,u)=>m("li",{},M(c,()=>u&&o("undo",u),{"aria-current":u===0?"step":null,title:u?"U\
ndo what came after":"The latest"}))),l=m("li",{},M(n.undo.length<50?"As it was opened":"Further back",()=>n.undo.length&&o("undo",n.undo.length),
{"aria-current":n.undo.length?null:"step"}));e.replaceChildren(...s.reverse(),...a,l)}),m("div",{class:"panel"},m("h2",{},"History"),e)}var ct=[["Black",[0,0,0,1]],["Cyan",[1,0,0,0]],["Magenta",[0,1,0,0]],["Yellow",[0,0,1,0]],["Sepia",[.3,.55,.75,.45]],["Red chalk",[.1,.8,.8,
.1]],["Blue ink",[1,.7,0,.3]]];var Nn=new Set(["size","strength","falloff"]),$n=new Set(["path","on","layer"]),J=class r{changed=new P;own=new Map;static shown(e){return e.
knobs.filter(t=>!$n.has(t.name))}get(e,t){let n=this.own.get(this.key(e,t));return n===void 0?e.knobs.find(i=>i.name===t)?.default??null:n}set(e,t,n){
this.own.set(this.key(e,t),n),this.changed.say(t)}scale(e,t,n){let i=e.knobs.find(a=>a.name===t),o=this.get(e,t);if(!i||typeof o!="number")return;
let s=Number((o*n).toPrecision(2));this.set(e,t,Math.min(i.high??s,Math.max(Math.max(i.low??s,.01),s)))}params(e){let t={};for(let n of r.shown(
e)){let i=this.get(e,n.name);i!==null&&JSON.stringify(i)!==JSON.stringify(n.default)&&(t[n.name]=i)}return t}key(e,t){return Nn.has(t)&&e.knobs.
some(n=>n.name==="path")&&e.group!=="relax"?t:`${e.name} ${t}`}};function K(r,e,t){let i=J.shown(e).filter(s=>!t||t.includes(s.name)).map(s=>{let a=r.settings.get(e,s.name);return{name:s.name,...se(s,a,l=>r.
settings.set(e,s.name,l),r.libraries)}}),o=m("div",{class:"knobs"},...i.map(s=>s.element));return r.settings.changed.on(s=>{if(o.isConnected)
for(let a of i)a.name===s&&!a.element.contains(document.activeElement)&&a.show(r.settings.get(e,s))}),o}function q(r,e,t=$(e.name),n=()=>({})){
let i=()=>{r.apply(e.name,{...r.settings.params(e),...n()})};return m("div",{class:"stack"},m("p",{class:"help"},e.help),K(r,e),M(t,i,{class:"\
wide"}))}function ut(r){let e=m("p",{class:"count"}),t=m("section",{class:"section stack","aria-label":"Paper"},m("h2",{},"Paper"),e);return r.drawing.
hello.on(n=>{if(!n)return;let[i,o]=n.size.map(s=>Number(s.toFixed(2)));e.textContent=`${i} × ${o} mm${n.margin===null?"":`, margin ${Number(
n.margin.toFixed(2))} mm`}`}),r.drawing.begun(()=>{let n=r.operation("paper");n&&t.append(m("details",{},m("summary",{},"Another paper"),q(r,
n,"Put it on this paper")))}),t}function ht(r){let e=m("ul",{class:"layers","aria-label":"Layers, the topmost first"}),t=m("section",{class:"section stack","aria-label":"Th\
e layer worked on"}),n=m("input",{type:"radio",name:"layer",id:x("layer"),checked:!0,change:()=>r.layer.value=null}),i=z(C.add,"Add a layer",
()=>{r.apply("layer add",{})}),o="",s=()=>t.contains(document.activeElement)&&document.activeElement instanceof HTMLInputElement,a=()=>{let c=r.
drawing.state.value;if(!c)return;r.layer.value!==null&&!c.layers.some(p=>p.id===r.layer.value)&&(r.layer.value=null);let u=JSON.stringify([c.
layers,r.layer.value,c.selected>0]);if(u===o)return;o=u;let h=document.activeElement instanceof HTMLElement?document.activeElement.dataset.focus:
void 0;n.checked=r.layer.value===null,e.replaceChildren(...c.layers.map((p,f)=>Un(r,p,f,c.layers.length)).reverse());let d=c.layers.find(p=>p.
id===r.layer.value);s()?o="":Kn(t,d?Bn(r,d,c.selected):[]),t.hidden=!d,h&&e.querySelector(`[data-focus="${h}"]`)?.focus()};t.addEventListener(
"focusout",()=>setTimeout(()=>t.matches(":active")||a())),r.drawing.state.on(a),r.layer.on(a);let l=m("div",{class:"layer layer-all"},n,m("l\
abel",{for:n.id},"Work on all layers"),i);return m("div",{class:"panel"},m("h2",{},"Layers"),l,e,t,ut(r))}function Kn(r,e){let t=()=>[...r.querySelectorAll(
"input, select, button")],n=t().indexOf(document.activeElement);r.replaceChildren(...e),t()[n]?.focus()}function X(r,e,t){r.apply("layer edi\
t",{layer:e.id,...t})}function Un(r,e,t,n){let i=x("layer"),o=u=>({"data-focus":`${e.id} ${u}`}),s=m("input",{type:"radio",name:"layer",id:i,
checked:r.layer.value===e.id,change:()=>r.layer.value=e.id,...o("radio")}),a=m("span",{class:"swatch"});a.style.background=`rgb(${e.rgb.join(
" ")})`;let l=(u,h,d)=>{let p=`${u==="hidden"?"Hide":"Lock"} ${e.name}`,f=()=>X(r,e,{[u]:!e[u]});return z(C[e[u]?h:d],p,f,{"aria-pressed":String(
e[u]),...o(u)})},c=(u,h,d)=>z(C[h],`${u} ${e.name}`,()=>{r.apply("layer order",{layer:e.id,to:d})},{disabled:d<0||d>=n,...o(h)});return m("l\
i",{class:e.hidden?"layer layer-hidden":"layer"},s,a,m("label",{for:i},e.name||`Layer ${e.id}`,m("small",{},e.items.toLocaleString("en"))),c(
"Raise","up",t+1),c("Lower","down",t-1),l("locked","locked","open"),l("hidden","hidden","shown"))}function Bn(r,e,t){let n=he("Name",m("inpu\
t",{type:"text",value:e.name,change:s=>X(r,e,{name:me(s)})})),i=M("Bring the selection here",()=>{r.apply("layer take",{layer:e.id})},{class:"\
wide",disabled:!t}),o=M("Select all of it",()=>{r.apply("select",{by:"layer",layer:e.id})},{class:"wide"});return[m("h3",{},e.name||`Layer ${e.
id}`),n,...e.kind==="still"?[]:[...zn(r,e),i,o],M("Remove the layer",()=>{r.apply("layer remove",{layer:e.id})},{class:"wide"})]}function zn(r,e){
let t=()=>r.drawing.state.value?.layers.find(c=>c.id===e.id)??e,n=c=>X(r,e,{cmyk:c,...t().spot?{spot:t().ink}:{}}),i=m("input",{type:"number",
min:0,max:50,step:"any",value:e.pen??0,change:c=>X(r,e,{pen:Number(me(c))})}),o=m("select",{change:()=>o.value==="spot"?s.hidden=!1:X(r,e,{spot:""})},
m("option",{value:"process",selected:!e.spot},"process"),m("option",{value:"spot",selected:e.spot},"spot")),s=he("Spot name",m("input",{type:"\
text",value:e.spot?e.ink:"",placeholder:"as in the swatch book",spellcheck:"false",change:c=>X(r,e,{spot:me(c)})}));s.hidden=!e.spot;let a=e.
cmyk.map((c,u)=>m("input",{type:"number",min:0,max:100,step:1,value:Math.round(c*100),"aria-label":`${["Cyan","Magenta","Yellow","Black"][u]}\
, per cent`,change:h=>n(t().cmyk.map((d,p)=>p===u?Number(me(h))/100:d))})),l=ct.map(([c,u])=>M(c,()=>n(u)));return[he("Pen",i,m("span",{class:"\
unit"},"mm; 0 fills")),he("Ink",o),s,m("div",{class:"knob"},m("span",{},e.spot?"Looks like":"C M Y K"),m("div",{class:"knob-inputs cmyk"},...a)),
m("div",{class:"row chips"},...l)]}function he(r,e,...t){return e.id=x("field"),m("div",{class:"knob"},m("label",{for:e.id},r),m("div",{class:"\
knob-inputs"},e,...t))}function me(r){return r.target.value}var mt=[200,500,1e3,2e3,4e3],Fn=1001,Wn=1009,de=class{constructor(e){this.wire=e}wire;line=new L("connecting");said=new P;frames=new P;lost=new P;socket=null;number=0;tries=0;waiting=new Map;connect(){
let e=this.wire.open();this.socket=e,e.addEventListener("open",()=>{this.tries=0,this.line.value="open"}),e.addEventListener("message",t=>{let{
data:n}=t;typeof n=="string"?this.hear(JSON.parse(n)):this.frames.say(n)}),e.addEventListener("close",t=>this.closed(t.code))}ask(e){if(this.
socket?.readyState!==WebSocket.OPEN)return Promise.reject(new Error("There is no connection to the server."));let t=++this.number;return this.
socket.send(JSON.stringify({...e,n:t})),new Promise((n,i)=>this.waiting.set(t,{done:n,failed:i}))}hear(e){(e.say==="done"||e.say==="error")&&
this.answered(e),e.say==="closed"&&(this.line.value="ended"),this.said.say(e)}answered(e){if(e.say==="error"&&e.n===null)return this.lost.say(
e.text);let t=this.waiting.get(e.n??0);this.waiting.delete(e.n??0),e.say==="done"?t?.done(e):t?.failed(new Error(e.text))}closed(e){this.socket=
null;let t=e===Wn?"That was more than the server takes at once.":"The connection broke before the server answered.";for(let{failed:n}of this.
waiting.values())n(new Error(t));this.waiting.clear(),e===Fn?this.line.value="ended":this.line.value!=="ended"&&(this.line.value="broken"),setTimeout(
()=>this.connect(),mt[Math.min(this.tries++,mt.length-1)])}};var dt=6e3,pe=class{list=w("messages");note(e){this.show(e,"note",dt)}error(e){this.show(e,"error",2*dt)}show(e,t,n){for(let o of[...this.list.
children])(o.textContent===e||this.list.children.length>3)&&o.remove();let i=m("p",{class:t},e);i.addEventListener("click",()=>i.remove()),this.
list.append(i),setTimeout(()=>i.remove(),n)}};function gt(r,e){let[t,n]=r.viewport.px(e.left,e.top),[i,o]=r.viewport.px(e.right,e.bottom);return{left:t-4,top:n-4,right:i+4,bottom:o+4,knob:[
(t+i)/2,n-4-22]}}function bt(r,e,t){let{left:n,top:i,right:o,bottom:s,knob:a}=gt(r,t);e.strokeRect(n,i,o-n,s-i),e.beginPath(),e.moveTo(a[0],
i),e.lineTo(a[0],a[1]+5),e.stroke(),e.beginPath(),e.arc(...a,5,0,2*Math.PI),e.save(),e.fillStyle="#fff",e.fill(),e.restore(),e.stroke()}function vt(r,e){
let t=r.drawing.selection();if(!t||!r.operation("move"))return null;let{left:n,top:i,right:o,bottom:s,knob:a}=gt(r,t),[l,c]=r.viewport.px(e.
x,e.y);return Math.hypot(l-a[0],c-a[1])<=10?pt(r,e,t,!0):l>=n&&l<=o&&c>=i&&c<=s?pt(r,e,t,!1):null}function pt(r,e,t,n){let i=Vn(r),[o,s,a]=[
0,0,0];return{move:l=>{let c=l[l.length-1];n?a=ft(c.x-i[0],c.y-i[1])-ft(e.x-i[0],e.y-i[1]):[o,s]=[c.x-e.x,c.y-e.y]},end:()=>{let l=u=>Math.round(
u*1e3)/1e3,c=n?{angle:l((a+540)%360-180)}:{dx:l(o),dy:l(s)};Object.values(c).some(u=>u!==0)?r.apply("move",c):n||r.apply("select",{by:"pick",
path:[e.x,e.y,1]})},cancel:()=>{},draw:l=>Gn(r,l,t,i,o,s,a*Math.PI/180)}}function Vn(r){let{items:e}=r.drawing,[t,n,i,o]=[1/0,1/0,-1/0,-1/0];
for(let s of r.drawing.selected())[t,i]=[Math.min(t,e.x[s]),Math.max(i,e.x[s])],[n,o]=[Math.min(n,e.y[s]),Math.max(o,e.y[s])];return[(t+i)/2e3,
(n+o)/2e3]}function ft(r,e){return Math.atan2(e,r)*180/Math.PI}function Gn(r,e,t,n,i,o,s){let{drawing:a,viewport:l}=r,{items:c}=a,u=l.scale/
l.ratio,h=(d,p)=>{let[f,g]=[d-n[0],p-n[1]];return l.px(n[0]+Math.cos(s)*f-Math.sin(s)*g+i,n[1]+Math.sin(s)*f+Math.cos(s)*g+o)};if(e.beginPath(),
a.state.value.selected>400){let{left:d,top:p,right:f,bottom:g}=t;for(let v of[[d,p],[f,p],[f,g],[d,g]])e.lineTo(...h(...v));return e.closePath(),
e.stroke()}for(let d of a.selected()){let p=a.kinds.get(c.kind[d]);if(!p)continue;let[f,g]=h(c.x[d]/1e3,c.y[d]/1e3),v=c.scale[d]/1e3*u,y=c.turn[d]/
65536*2*Math.PI+s,[T,E]=[v*Math.cos(y),v*Math.sin(y)];for(let{xy:k,closed:H}of p.rings(v)){for(let S=0;S<k.length;S+=2){let[R,N]=[f+T*k[S]-E*
k[S+1],g+E*k[S]+T*k[S+1]];S?e.lineTo(R,N):e.moveTo(R,N)}H&&e.closePath()}}e.stroke()}function wt(r){let e=10**Math.floor(Math.log10(r));return[1,2,5,10].map(t=>t*e).find(t=>t>=r*.999)}function Mt(r,e,t){let[n,i]=[e.width/e.ratio,
e.height/e.ratio];r.fillStyle=t.ground,r.fillRect(0,0,n,18),r.fillRect(0,0,18,i),r.font="10px ui-sans-serif, system-ui, sans-serif",r.textBaseline=
"alphabetic",r.lineWidth=1,r.setLineDash([]),r.strokeStyle=t.stroke,yt(r,e,n,t,!1),r.save(),r.transform(0,1,1,0,0,0),yt(r,e,i,t,!0),r.restore(),
r.fillStyle=t.ground,r.fillRect(0,0,18,18),r.fillStyle=t.text,r.fillText("mm",2,12)}function yt(r,e,t,n,i){let o=e.scale/e.ratio,s=(i?e.y:e.
x)/e.ratio,a=wt(56/o),l=[10,5,2].map(u=>a/u).find(u=>u*o>=5&&jn(u))??a,c=Math.round(a/l);r.beginPath();for(let u=Math.floor((18-s)/o/l);u*l*
o+s<t;u++){let h=Math.round(u*l*o+s)+.5,d=u%c===0;r.moveTo(h,18),r.lineTo(h,d?4:14),d&&Zn(r,Number((u*l).toPrecision(9)),h,n,i)}r.stroke(),r.
beginPath(),r.moveTo(0,18-.5),r.lineTo(t,18-.5),r.stroke()}function jn(r){return Math.abs(wt(r)-r)<1e-6*r}function Zn(r,e,t,n,i){if(r.fillStyle=
n.text,!i)return r.fillText(String(e),t+3,11);r.save(),r.transform(0,1,1,0,0,0),r.translate(3,t+3),r.rotate(Math.PI/2),r.fillText(String(e),
0,0),r.restore()}var fe=class{constructor(e){this.desk=e;let{drawing:t,viewport:n,appearance:i,tool:o,region:s,settings:a}=e,l=()=>this.ask();for(let u of[n.
changed,i.changed])u.on(l);let c="";t.changed.on(()=>{let{wall:u=null,selected:h=0}=t.state.value??{},d=JSON.stringify([u,h,t.canvas]);(h||d!==
c)&&l(),c=d});for(let u of[t.hello,o,s])u.on(l);a.changed.on(l)}desk;gesture=null;canvas=w("overlay");ring=w("ring");cross=w("cross");notches=[
w("across"),w("down")];pointer=null;asked=!1;point(e,t=!1){this.pointer=e,this.cross.hidden=!(e&&t),e&&(this.cross.style.transform=`translat\
e(${e[0]}px, ${e[1]}px)`),this.follow()}ask(){this.asked||(this.asked=!0,requestAnimationFrame(()=>this.draw()))}follow(){let[e,t]=this.notches;
e.hidden=t.hidden=!(this.pointer&&this.desk.appearance.rulers.value),this.pointer&&(e.style.transform=`translateX(${this.pointer[0]}px)`),this.
pointer&&(t.style.transform=`translateY(${this.pointer[1]}px)`);let{tool:n,settings:i,viewport:o}=this.desk,s=n.value,a=this.pointer&&s?.ring&&
s.operation;if(this.ring.hidden=!a,!a||!this.pointer)return;let l=Number(i.get(s.operation,"size")),c=Math.max(3,l*o.scale/o.ratio),[u,h]=[this.
pointer[0]-c/2,this.pointer[1]-c/2];this.ring.style.transform=`translate(${u}px, ${h}px)`,this.ring.style.width=this.ring.style.height=`${c}\
px`}draw(){this.asked=!1,this.follow();let{canvas:e,desk:t}=this,{viewport:n,drawing:i,appearance:o}=t;(e.width!==n.width||e.height!==n.height)&&
([e.width,e.height]=[n.width,n.height]);let s=e.getContext("2d");if(s.setTransform(n.ratio,0,0,n.ratio,0,0),s.clearRect(0,0,e.width,e.height),
!i.hello.value)return;o.guides.value&&this.guides(s),this.outlines(s);let a={ground:o.colour("panel"),stroke:o.colour("ruler"),text:o.colour(
"muted")};o.rulers.value&&Mt(s,n,a)}outlines(e){let{drawing:t,appearance:n,region:i,tool:o}=this.desk,s=o.value?.part==="select"&&!this.gesture?.
draw?t.selection():null,a=n.colour("accent-on-paper");for(let l of[!0,!1]){let c=(u,h)=>{e.strokeStyle=l?"#fffd":u,e.lineWidth=l?4:1.5,e.setLineDash(
l?[]:h)};c(n.colour("wall"),[6,3]);for(let u of t.state.value?.wall??[])this.outline(e,u,2);c(a,[6,3]),i.value&&this.outline(e,i.value,3),c(
a,[]),s&&bt(this.desk,e,s),e.fillStyle=l?"transparent":`color-mix(in srgb, ${a} 12%, transparent)`,this.gesture?.draw?.(e)}}guides(e){let{viewport:t,
drawing:n,appearance:i}=this.desk,{size:o,margin:s}=n.hello.value,a=l=>{let[[c,u],[h,d]]=[t.px(l,l),t.px(o[0]-l,o[1]-l)];e.strokeRect(Math.round(
c)+.5,Math.round(u)+.5,Math.round(h-c)-1,Math.round(d-u)-1)};e.lineWidth=1,e.setLineDash([]),e.strokeStyle=i.colour("edge"),a(0),e.setLineDash(
[2,3]),e.strokeStyle=i.colour("guide"),s&&a(s);for(let l of n.canvas)this.outline(e,l,2)}outline(e,t,n){e.beginPath();for(let i=0;i+1<t.length;i+=
n)e.lineTo(...this.desk.viewport.px(t[i],t[i+1]));e.closePath(),e.stroke()}};var ge=class{constructor(e,t,n,i,o){this.surface=e;this.viewport=t;this.begin=n;this.hover=i;this.drawn=o;e.addEventListener("pointerdown",s=>this.
down(s)),e.addEventListener("pointermove",s=>this.move(s)),e.addEventListener("pointerup",s=>this.up(s,!1)),e.addEventListener("pointercance\
l",s=>this.up(s,!0)),e.addEventListener("pointerleave",s=>this.hover(s.offsetX,s.offsetY,!1)),e.addEventListener("contextmenu",s=>s.preventDefault()),
e.addEventListener("wheel",s=>this.wheel(s),{passive:!1})}surface;viewport;begin;hover;drawn;gesture=null;owner=-1;panning=!1;waiting=null;fingers=new Map;space=!1;get busy(){
return this.gesture!==null}cancel(){this.drop(),this.finish(e=>e.cancel())}place(e){let t=this.surface.getBoundingClientRect();return{x:e.clientX-
t.left,y:e.clientY-t.top}}point(e){let{x:t,y:n}=this.place(e),[i,o]=this.viewport.mm(t,n);return{x:i,y:o,pressure:e.pointerType==="pen"?e.pressure:
1}}down(e){if(this.surface.focus({preventScroll:!0}),this.surface.setPointerCapture(e.pointerId),e.pointerType==="touch"&&(this.fingers.set(
e.pointerId,this.place(e)),this.fingers.size>1))return this.cancel();if(this.gesture||this.panning)return;if(e.button===1||this.space){this.
panning=!0,this.owner=e.pointerId,this.fingers.set(e.pointerId,this.place(e));return}if(e.button!==0)return;this.owner=e.pointerId;let[t,n]=[
this.point(e),{shift:e.shiftKey,alt:e.altKey}],i=()=>{this.drop(),this.gesture=this.begin(t,n),this.drawn(this.gesture)};e.pointerType==="to\
uch"?this.waiting={start:i,timer:setTimeout(i,80),...this.place(e)}:i()}drop(){clearTimeout(this.waiting?.timer),this.waiting=null}move(e){let{
x:t,y:n}=this.place(e);this.hover(t,n,e.pointerType!=="touch"||this.gesture!==null);let i=this.fingers.get(e.pointerId);if(i&&(this.fingers.
size>1||this.panning))return this.pinch(e.pointerId,i,{x:t,y:n});if(i&&this.fingers.set(e.pointerId,{x:t,y:n}),this.waiting&&Math.hypot(t-this.
waiting.x,n-this.waiting.y)>5&&this.waiting.start(),!this.gesture||e.pointerId!==this.owner)return;let o=e.getCoalescedEvents?.()??[];this.gesture.
move((o.length?o:[e]).map(s=>this.point(s))),this.drawn(this.gesture)}pinch(e,t,n){let i=[...this.fingers].find(([a])=>a!==e)?.[1];if(this.fingers.
set(e,n),!i)return this.viewport.pan(n.x-t.x,n.y-t.y);let[o,s]=[Math.hypot(t.x-i.x,t.y-i.y),Math.hypot(n.x-i.x,n.y-i.y)];this.viewport.pan((n.
x-t.x)/2,(n.y-t.y)/2),o>10&&s>10&&this.viewport.zoom(s/o,(n.x+i.x)/2,(n.y+i.y)/2)}up(e,t){this.fingers.delete(e.pointerId),e.pointerId===this.
owner&&(this.panning=!1,t||this.waiting?.start(),this.finish(n=>t?n.cancel():n.end()))}finish(e){let{gesture:t}=this;this.gesture=null,t&&e(
t),this.drawn(null)}wheel(e){e.preventDefault();let t=e.deltaMode===1?16:e.deltaMode===2?400:1,[n,i]=[e.deltaX*t,e.deltaY*t],{x:o,y:s}=this.
place(e);e.ctrlKey||e.metaKey?this.viewport.zoom(Math.exp(-Math.max(-60,Math.min(60,i))*.006),o,s):e.shiftKey&&!n?this.viewport.pan(-i,0):this.
viewport.pan(-n,-i)}};var Yn={ArrowLeft:[-1,0],ArrowRight:[1,0],ArrowUp:[0,-1],ArrowDown:[0,1]};function kt(r,e,t){let{viewport:n}=r,i=w("surface"),o=null,s=(c,u,h)=>{
o=null,e.point(h?[c,u]:null),t.point(h?n.mm(c,u):null)},a=(c,u)=>r.link.line.value==="open"?r.tool.value?.begin(c,u)??null:null,l=new ge(i,n,
a,s,c=>{e.gesture=c,e.ask()});return i.addEventListener("keydown",c=>{let u=Yn[c.key];if(c.ctrlKey||c.metaKey||!u&&c.key!=="Enter")return;c.
preventDefault();let h=c.shiftKey?10:1;o??=n.mm(n.width/n.ratio/2,n.height/n.ratio/2),u?o=[o[0]+h*u[0],o[1]+h*u[1]]:a({x:o[0],y:o[1],pressure:1},
{shift:c.shiftKey,alt:c.altKey})?.end(),e.point(n.px(...o),!0),t.point(o)}),i.addEventListener("blur",()=>o&&s(0,0,!1)),Jn(i,l),r.tool.on(c=>i.
dataset.part=c?.part??""),l}function Jn(r,e){let t=n=>{e.space=n,r.classList.toggle("panning",n)};window.addEventListener("keydown",n=>{n.key!==
" "||n.target!==r&&n.target!==document.body||(n.preventDefault(),t(!0))}),window.addEventListener("keyup",n=>{n.key===" "&&t(!1)}),window.addEventListener(
"blur",()=>t(!1))}var qn="insert";function xt(r){let e=w("rail"),t=new Map;r.tools.on(n=>{t=new Map(n.map(s=>[s.name,Xn(r,s)]));let o=["look","select","brush",
"outline"].map(s=>m("div",{class:"rail-part"},...n.filter(a=>a.part===s).map(a=>t.get(a.name))));e.replaceChildren(...o.filter(s=>s.children.
length)),r.tool.value=n.find(s=>s.name===(r.tool.value?.name??qn))??n[0]??null}),r.tool.on(n=>{for(let[i,o]of t)o.setAttribute("aria-pressed",
String(i===n?.name)),o.tabIndex=i===n?.name?0:-1}),e.addEventListener("keydown",n=>Re(n,[...t.values()]))}function Xn(r,e){let t=`${e.title}${e.
key?` (${e.key.toUpperCase()})`:""}: ${e.help}`,n=e.key?{"aria-keyshortcuts":e.key}:{},i=z(C[e.name]??C.insert,e.title,()=>r.tool.value=e,{"\
data-tool":e.name,...n});return i.title=t,i}function Re(r,e){let t=e.indexOf(document.activeElement),n={ArrowDown:t+1,ArrowRight:t+1,ArrowUp:t-
1,ArrowLeft:t-1,Home:0,End:e.length-1}[r.key];t<0||n===void 0||(r.preventDefault(),r.stopPropagation(),e[(n+e.length)%e.length].focus())}var Et=256,Ne=56,be=4,ve=class{constructor(e){this.name=e;let t=document.createElementNS("http://www.w3.org/2000/svg","svg");t.setAttribute(
"viewBox",`0 0 ${Et} ${Ne}`),t.setAttribute("aria-hidden","true"),t.append(this.line),this.element=m("figure",{class:"plot"},m("figcaption",
{},m("span",{},e),this.now),t)}name;element;line=document.createElementNS("http://www.w3.org/2000/svg","polyline");now=m("span",{class:"plot\
-now"});values=[];clear(){this.values.length=0,this.draw()}add(e,t){Number.isFinite(t)&&(this.values.push([e,t]),this.values.length>2e3&&this.
values.splice(0,this.values.length,...this.values.filter((n,i)=>i%2)),this.draw())}draw(){let{values:e}=this,[t,n]=[e[0]?.[0]??0,e[e.length-
1]?.[0]??1],i=Math.min(...e.map(([,l])=>l)),o=Math.max(...e.map(([,l])=>l)),s=l=>be+(l-t)/Math.max(n-t,1)*(Et-2*be),a=l=>Ne-be-(l-i)/(o-i||1)*
(Ne-2*be);this.line.setAttribute("points",e.map(([l,c])=>`${s(l).toFixed(1)},${a(c).toFixed(1)}`).join(" ")),this.now.textContent=e.length?Number(
e[e.length-1][1].toPrecision(4)).toString():""}};var Qn=["energy","movement","turning"];function Tt(r){let e=m("div",{class:"panel"});return r.drawing.begun(t=>{let n=r.operation("relax"),i=t.
operations.filter(o=>o.group==="relax"&&o!==n);e.replaceChildren(...n?er(r,n):[],...i.map(o=>_n(r,o)))}),e}function _n(r,e){let t=()=>{let i=e.
knobs.some(o=>o.name==="path")?r.region.value:null;return i?{path:i}:{}},n=q(r,e,void 0,()=>({...t(),...r.ofLayer(e)}));return m("details",{
class:"section"},m("summary",{},e.name==="tile"?"Lay tiles":e.name==="cut"?"Cut stones":e.name),n)}function er(r,e){let t=m("select",{id:x("\
on")},...["all","selection"].map(p=>m("option",{value:p},p))),n=m("input",{type:"number",id:x("steps"),min:1,max:1e4,step:1,value:10}),i=Qn.
map(p=>new ve(p)),o=m("p",{class:"count",role:"status"}),s=p=>{if(p>1||!p)for(let g of i)g.clear();let f={...r.settings.params(e),...r.ofLayer(
e),on:t.value};r.apply(e.name,f,{times:p}).then(g=>{g&&(o.textContent=g.stopped?"Stopped":"")})},a=()=>{n.reportValidity()&&s(n.valueAsNumber)},
l=$e("Play","play",()=>{let{busy:p}=r.drawing.state.value??{};p?r.ask({do:p.paused?"resume":"pause"}):s(0)}),c=$e("Stop","stop",()=>{r.ask({
do:"stop"})}),u=$e("Undo it","cancel",()=>{r.ask({do:"cancel"})}),h=M("1 step",()=>s(1)),d=M("steps",a);return r.drawing.steps.on(p=>{if(p.stage!==
"recover"){o.textContent=`${p.stage} ${p.done}${p.total?` of ${p.total}`:""}`;for(let f of i){let g=p.facts[f.name];g!==void 0&&f.add(p.done,
g),f.element.hidden=g===void 0&&f.name==="turning"}}}),r.drawing.state.on(p=>{let f=p?.busy??null,g=f!==null&&!f.paused,v=g?"Pause":f?"Go on":
"Play";(l.getAttribute("aria-label")!==v||!l.childNodes.length)&&(B(l,{"aria-label":v}),l.replaceChildren(j(g?C.pause:C.play),v)),c.disabled=
u.disabled=!f,h.disabled=d.disabled=f!==null;for(let y of t.options)y.value==="selection"&&(y.disabled=!p?.selected);p?.selected||(t.value="\
all")}),[m("h2",{},"Relaxation"),m("p",{class:"help"},e.help),K(r,e,["variant"]),m("div",{class:"knob"},m("label",{for:t.id},"On"),m("div",{
class:"knob-inputs"},t)),m("div",{class:"row"},l,c,u),m("div",{class:"row"},h,m("span",{class:"joined"},m("label",{for:n.id,class:"unseen"},
"Number of steps"),n,d)),o,...i.map(p=>p.element),m("details",{},m("summary",{},"Finer settings"),K(r,e,tr(e)))]}function tr(r){return r.knobs.
map(e=>e.name).filter(e=>!["variant","size","strength","falloff"].includes(e))}function $e(r,e,t){return m("button",{type:"button",click:t,"\
aria-label":r},j(C[e]),r)}async function Lt(r){let e=await r.get("picture.png");return e&&createImageBitmap(e)}async function St(r,e,t){let n=await r.get(`still-${e}.\
svg`);if(!n)return null;let i=new Image;i.src=URL.createObjectURL(n),await i.decode(),URL.revokeObjectURL(i.src);let o=2e3/Math.max(...t),s=new OffscreenCanvas(
Math.ceil(t[0]*o),Math.ceil(t[1]*o));return s.getContext("2d").drawImage(i,0,0,s.width,s.height),s.transferToImageBitmap()}function At(r,e){let{viewport:t,appearance:n,drawing:i}=r,o=w("stage"),s=w("drawing").transferControlToOffscreen();e({do:"canvas",canvas:s},
[s]);let a=!1;t.changed.on(()=>{a||(a=!0,requestAnimationFrame(()=>{a=!1,e({do:"view",view:t.view,width:t.width,height:t.height})}))});let l=()=>{
let[h,d]=[o.clientWidth,o.clientHeight].map(p=>Math.round(p*devicePixelRatio));t.resize(h,d,devicePixelRatio)};new ResizeObserver(l).observe(
o),l();let c=()=>e({do:"look",look:n.look});n.changed.on(c),c();let u="";i.hello.on(h=>{if(!h)return;let d=JSON.stringify([h.name,h.size]);d!==
u&&t.show(h.size),u=d}),nr(r,e)}function nr(r,e){let{drawing:t}=r,{wire:n}=r.link,i=(s,a)=>e({do:"image",name:s,bitmap:a},a?[a]:[]),o=new Set;
t.hello.on(s=>{o.clear(),s&&(s.picture?Lt(n).then(a=>i("picture",a)):i("picture",null))}),t.state.on(s=>{let{size:a}=t.hello.value??{};for(let{
id:l,kind:c}of s?.layers??[])c!=="still"||o.has(l)||!a||(o.add(l),St(n,l,a).then(u=>i(l,u)))})}var rr={connecting:"",open:"",broken:"The connection broke. Nothing is lost; connecting again…"},ye=class{constructor(e){this.desk=e;let{drawing:t,
viewport:n,link:i}=e;n.changed.on(()=>this.scale()),t.changed.on(()=>{let{marks:s=0,selected:a=0}=t.state.value??{};ie(w("count"),`${s.toLocaleString(
"en")} marks${a?`, ${a.toLocaleString("en")} selected`:""}`)}),t.hello.on(s=>{s&&(w("name").textContent=s.name,document.title=`${s.name} · c\
rowquill`)});let o=w("saved");t.saved.on(s=>{o.textContent=!s||s.ok?"Every change is saved":s.text||`${s.waiting} changes are not saved yet`,
B(o,{"data-ok":String(s?.ok??!0),role:s?.ok===!1?"alert":"status"})}),t.tabs.on(s=>{w("tab-count").textContent=s>1?`Open in ${s} tabs`:""}),
i.line.on(s=>{this.banner(this.lineText(s)),B(w("app"),{"data-line":s})}),t.steps.on(s=>{s.stage==="recover"&&this.banner(`Doing again what \
was done: ${s.done} of ${s.total} changes`)}),t.state.on(s=>s&&this.banner(this.lineText(i.line.value)))}desk;zoom=w("zoom");place=w("place");point(e){
let t=this.desk.viewport.scale,n=Math.max(1,Math.min(3,Math.ceil(Math.log10(t))));this.place.textContent=e?`${e[0].toFixed(n)}, ${e[1].toFixed(
n)} mm`:""}lineText(e){return e==="ended"?this.desk.link.wire.ended:rr[e]}banner(e){let t=w("banner");t.textContent!==e&&(t.textContent=e),t.
hidden=!e}scale(){let{scale:e,ratio:t}=this.desk.viewport,n=e/t*25.4*100/96;this.zoom.textContent=`${n<10?n.toPrecision(2):Math.round(n).toLocaleString(
"en")} %`}};var Pt="redraw stipple";function Ct(r){let e=m("div",{class:"panel"});return r.drawing.begun(t=>{let n=t.operations.filter(i=>i.group==="sty\
le");n.length&&e.replaceChildren(...or(r,n))}),e}function ir(r){return r.name.replace(/^redraw /,"")}function or(r,e){let t=m("select",{id:x(
"style")},...e.map(h=>m("option",{value:h.name},ir(h)))),n=m("div",{}),i=new Map;e.some(h=>h.name===Pt)&&(t.value=Pt);let o=()=>e.find(h=>h.
name===t.value),s=()=>{let h=o();i.has(h.name)||i.set(h.name,m("div",{class:"stack"},m("p",{class:"help"},h.help),K(r,h))),n.replaceChildren(
i.get(h.name))},a=m("p",{class:"help"}),l=h=>{let d=o();r.apply(d.name,{...r.settings.params(d),...h?{path:h}:{}})},c=M("Draw the region ane\
w",()=>l(r.region.value),{class:"wide primary"}),u=M("Draw all anew",()=>l(null),{class:"wide"});return r.region.on(h=>{c.hidden=!h,u.classList.
toggle("primary",!h),a.textContent=h?"The region is outlined on the canvas.":"To draw a part alone, outline it with the region tool (D)."}),
r.drawing.state.on(h=>c.disabled=u.disabled=!!h?.busy),t.addEventListener("change",s),s(),[m("h2",{},"Style"),m("div",{class:"knob"},m("labe\
l",{for:t.id},"Style"),m("div",{class:"knob-inputs"},t)),n,a,c,u]}function It(r){let[e,t]=[w("tabs"),w("panels")],n=r.map(({name:o,panel:s})=>{let[a,l]=[x("tab"),x("panel")];for(let[c,u]of Object.entries({id:l,
role:"tabpanel","aria-labelledby":a}))s.setAttribute(c,u);return m("button",{type:"button",role:"tab",id:a,"aria-controls":l,click:()=>i(o)},
o)}),i=o=>{r.forEach((s,a)=>{let l=s.name===o;s.panel.hidden=!l,n[a].setAttribute("aria-selected",String(l)),n[a].tabIndex=l?0:-1})};return e.
addEventListener("keydown",o=>{Re(o,n),document.activeElement!==o.target&&document.activeElement.click()}),e.replaceChildren(...n),t.replaceChildren(
...r.map(o=>o.panel)),i(r[0].name),i}function Dt(r){let e=m("div",{}),t=m("section",{class:"section stack","aria-label":"Selection"}),n=new Map;return r.tool.on(i=>{i&&(n.has(i)||
n.set(i,sr(r,i)),e.replaceChildren(n.get(i)))}),r.drawing.begun(()=>t.replaceChildren(...lr(r))),m("div",{class:"panel"},e,t)}function sr(r,e){
let{operation:t,part:n,name:i}=e;return m("div",{class:"stack"},m("h2",{},e.title),m("p",{class:"help"},e.help),t&&e.ring&&K(r,t,n==="select"?
["size"]:void 0),t&&n==="brush"&&ar(r,t),i==="wall"&&M("Take the wall away",()=>{r.apply("wall",{})},{class:"wide"}),i==="region"&&M("Forget\
 the region",()=>r.region.value=null,{class:"wide"}))}function ar(r,e){if(!e.knobs.some(i=>i.name==="on"))return null;let t=i=>()=>{r.apply(
e.name,{...r.settings.params(e),...r.ofLayer(e),on:i})},n=M("On the selection",t("selection"));return r.drawing.changed.on(()=>n.disabled=!r.
drawing.state.value?.selected),n.disabled=!r.drawing.state.value?.selected,m("div",{class:"row"},n,M("On all",t("all")))}function lr(r){let e=r.
operation("select");if(!e)return[];let t=m("p",{class:"count"}),n=[],i=(l,c,u)=>{if(!r.operation(c))return null;let h=M(l,()=>{r.apply(c,u)});
return n.push(h),h},o=(l,c)=>M(l,()=>{r.apply("select",{...c,...r.ofLayer(e)})}),s=m("details",{},m("summary",{},"By the tone beneath"),K(r,
e,["low","high"]),M("Select",()=>cr(r,e),{class:"wide"})),a=[m("h2",{},"Selection"),t,m("div",{class:"row"},o("All",{by:"all"}),o("None",{by:"\
none"}),o("Invert",{by:"invert"})),s,m("div",{class:"row"},i("Erase","erase",{on:"selection"}),i("Duplicate","duplicate",{})),m("div",{class:"\
row"},i("Freeze","freeze",{on:"selection"}),i("Thaw","freeze",{on:"selection",frozen:!1})),m("div",{class:"row"},i("Align to the flow","turn",
{on:"selection",by:"flow"})),ur(r)];return r.drawing.changed.on(()=>{let{selected:l=0,marks:c=0}=r.drawing.state.value??{};ie(t,`${l.toLocaleString(
"en")} of ${c.toLocaleString("en")} selected`);for(let u of n)u.disabled=!l}),a.filter(l=>l!==null)}function cr(r,e){let{low:t,high:n}={low:r.
settings.get(e,"low"),high:r.settings.get(e,"high")};r.apply("select",{by:"tone",low:t,high:n,...r.ofLayer(e)})}function ur(r){let e=r.operation(
"move");return e?m("details",{},m("summary",{},"Move and turn by numbers"),q(r,e,"Move")):null}var Ke=class{constructor(e,t){this.apart=t;this.last=e,this.left=t}apart;last;left;to(e){let t=[],{last:n}=this,i=Math.hypot(e.x-n.x,e.y-n.y),
o=this.left;for(;o<=i;o+=this.apart)t.push(hr(n,e,o/i));return this.left=o-i,this.last=e,t}};function hr(r,e,t){let n=(i,o)=>i+t*(o-i);return{
x:n(r.x,e.x),y:n(r.y,e.y),pressure:n(r.pressure,e.pressure)}}function Ue(r,e){let t=new Ke(r,Math.max(e.size*.12,.02)),n=[r],i=null,o=r,s=0,
a=!1,l=!1,c=()=>n.length>=(a?1:e.least)&&(!e.lead||i!==null||n.length>1),u=()=>{for(;!l&&s<2&&c();){let f=n.splice(0,Math.floor(e.most/3)-1),
g=e.lead&&i?[i,...f]:f;i=f[f.length-1],s++;let v=g.flatMap(y=>[Ot(y.x),Ot(y.y),Math.round(y.pressure*1e3)/1e3]);e.send(v).then(h,()=>l=!0)}},
h=()=>{s--,u()},d=e.lingers?setInterval(()=>{s||n.length||(n.push(o),u())},70):void 0,p=()=>{a=!0,clearInterval(d),u()};return u(),{move(f){
for(let g of f)n.push(...t.to(o=g));u()},end(){o!==(n[n.length-1]??i)&&n.push(o),p()},cancel(){n=[],p()}}}function Ot(r){return Math.round(r*
1e3)/1e3}var Ht={insert:"b",erase:"e",push:"p",attract:"a",jitter:"j",resize:"s",turn:"t",swap:"g",freeze:"f",paint:"i",relax:"r"},mr=new Set(["inser\
t","attract","jitter","relax","paint"]);function Rt(r,e){let t=e.filter(s=>Be(s,"path")&&Be(s,"size")&&s.group!=="select"&&s.group!=="style"),
n=Object.keys(Ht),i=s=>n.includes(s.name)?n.indexOf(s.name):n.length;t.sort((s,a)=>i(s)-i(a));let o=e.find(s=>s.name==="select");return[...dr(
r),...o?pr(r,o):[],...t.map(s=>fr(r,s)),...br(r,e)]}function Nt(r){let e=()=>{let t=r.tool.value?.operation,n=t?.name==="paint"?r.settings.get(
t,"map"):null;r.appearance.instead.value=n==="tone"||n==="importance"?n:null};r.tool.on(e),r.settings.changed.on(e)}function Be(r,e){return r.
knobs.some(t=>t.name===e)}function dr(r){return[{name:"pan",title:"Pan",help:"Drag the paper about",key:"h",part:"look",operation:null,ring:!1,
begin:t=>{let{viewport:n}=r;return{move:i=>{let o=i[i.length-1],[s,a]=[(o.x-t.x)*n.scale,(o.y-t.y)*n.scale];n.pan(s/n.ratio,a/n.ratio)},end:()=>{},
cancel:()=>{}}}}]}function we(r){return r.alt?"remove":r.shift?"add":"replace"}function pr(r,e){let t=(c,u,h,d={})=>{r.apply("select",{by:c,
mode:we(u),path:h,...d,...r.ofLayer(e)})},n=(c,u,h,d,p=!1)=>({name:c,title:$(c),help:`${h}; Shift adds, Alt takes away`,key:u,part:"select",
operation:p?e:null,ring:p,begin:d}),i=(c,u)=>we(u)==="replace"?vt(r,c):null,o=(c,u)=>{let h=[c.x,c.y,1];return i(c,u)??vr(()=>t("pick",u,h))},
s=(c,u)=>i(c,u)??yr(r,c,h=>t("rectangle",u,[c.x,c.y,1,h.x,h.y,1]),()=>t("pick",u,[c.x,c.y,1])),a=(c,u)=>ze(r,c,h=>t("lasso",u,h)),l=(c,u)=>{
let h=r.settings.get(e,"size"),d=r.newGroup(),p=0;return Ue(c,{size:typeof h=="number"?h:5,lead:!1,least:1,lingers:!1,most:3*r.drawing.hello.
value.limits.path,send:f=>{let g=p++&&we(u)==="replace"?"add":we(u);return r.apply("select",{by:"brush",mode:g,path:f,size:h,...r.ofLayer(e)},
{group:d})}})};return[n("pick","v","Select the mark that you touch, and move or turn what is selected by its handles",o),n("rectangle","m","\
Select in a rectangle",s),n("lasso","l","Select inside an outline that you draw",a),n("select brush","q","Select under a brush",l,!0)]}function fr(r,e){
let t=(o,s)=>{let{settings:a}=r,l={...a.params(e),...r.ofLayer(e)},c=Number(a.get(e,"size")),u=e.name==="turn"?a.get(e,"by"):a.get(e,"turn"),
h=r.newGroup();return Ue(o,{size:c,lead:e.name==="push"||e.name==="turn"&&u==="stroke",least:e.name==="insert"&&u==="stroke"?2:1,lingers:mr.
has(e.name),most:3*r.drawing.hello.value.limits.path,send:async d=>{let p=Be(e,"on")?{on:"brush"}:{};if(!await r.apply(e.name,{...l,...s.alt?
gr(e,l):{},...p,size:c,path:d},{group:h}))throw new Error("refused")}})},{name:n,help:i}=e;return{name:n,title:$(n),help:i,key:Ht[n]??"",part:"\
brush",operation:e,ring:!0,begin:t}}function gr(r,e){let t=n=>e[n]??r.knobs.find(i=>i.name===n)?.default;return r.name==="resize"?{factor:1/
Number(t("factor"))}:r.name==="turn"?{angle:-Number(t("angle"))}:r.name==="freeze"?{frozen:!t("frozen")}:r.name==="paint"?{value:1-Number(t(
"value"))}:{}}function br(r,e){let t=[],n=e.find(o=>o.name==="wall"),i={part:"outline",operation:null,ring:!1};if(n){let o=s=>ze(r,s,a=>{r.apply(
"wall",{path:a})});t.push({name:"wall",title:"Wall",help:"Draw an outline that relaxation does not cross",key:"w",...i,begin:o})}if(e.some(o=>o.
group==="style")){let o=s=>ze(r,s,a=>r.region.value=a);t.push({name:"region",title:"Region",help:"Draw the outline of what a style shall dra\
w anew",key:"d",...i,begin:o})}return t}function vr(r){return{move:()=>{},end:r,cancel:()=>{}}}function yr(r,e,t,n){let i=e;return{move:o=>i=
o[o.length-1],end:()=>$t(r,e,i)<3?n():t(i),cancel:()=>{},draw:o=>{let[[s,a],[l,c]]=[r.viewport.px(e.x,e.y),r.viewport.px(i.x,i.y)];o.strokeRect(
s,a,l-s,c-a),o.fillRect(s,a,l-s,c-a)}}}function ze(r,e,t){let n=[e];return{move:i=>{for(let o of i)$t(r,n[n.length-1],o)>=2&&n.push(o)},end:()=>{
let i=n.flatMap(o=>[Math.round(o.x*1e3)/1e3,Math.round(o.y*1e3)/1e3,1]);n.length>2&&t(i.slice(0,3*r.drawing.hello.value.limits.path))},cancel:()=>{},
draw:i=>{i.beginPath();for(let{x:o,y:s}of n)i.lineTo(...r.viewport.px(o,s));i.fill("evenodd"),i.stroke()}}}function $t(r,e,t){return Math.hypot(
e.x-t.x,e.y-t.y)*r.viewport.scale/r.viewport.ratio}var wr=20,Mr=4e3,Kt=40,Me=class{changed=new P;scale=1;x=0;y=0;width=1;height=1;ratio=1;paper=[100,100];get view(){return{scale:this.scale,x:this.
x,y:this.y}}mm(e,t){return[(e*this.ratio-this.x)/this.scale,(t*this.ratio-this.y)/this.scale]}px(e,t){return[(e*this.scale+this.x)/this.ratio,
(t*this.scale+this.y)/this.ratio]}resize(e,t,n){let i=n/this.ratio;[this.width,this.height,this.ratio]=[e,t,n],[this.scale,this.x,this.y]=[this.
scale*i,this.x*i,this.y*i],this.changed.say()}show(e){this.paper=e,this.fit({left:0,top:0,right:e[0],bottom:e[1]})}all(){this.fit({left:0,top:0,
right:this.paper[0],bottom:this.paper[1]})}fit(e){let t=Kt*this.ratio,[n,i]=[Math.max(e.right-e.left,.001),Math.max(e.bottom-e.top,.001)];this.
scale=this.bounded(Math.min((this.width-2*t)/n,(this.height-2*t)/i)),this.x=this.width/2-(e.left+e.right)/2*this.scale,this.y=this.height/2-
(e.top+e.bottom)/2*this.scale,this.changed.say()}pan(e,t){this.x+=e*this.ratio,this.y+=t*this.ratio,this.keep(),this.changed.say()}zoom(e,t=this.
width/this.ratio/2,n=this.height/this.ratio/2){let[i,o]=this.mm(t,n);this.scale=this.bounded(this.scale*e),this.x=t*this.ratio-i*this.scale,
this.y=n*this.ratio-o*this.scale,this.keep(),this.changed.say()}set(e){this.zoom(e/this.scale)}bounded(e){return Math.min(Mr*this.ratio,Math.
max(wr/Math.max(...this.paper),e))}keep(){let e=Kt*this.ratio;this.x=Math.min(this.width-e,Math.max(e-this.paper[0]*this.scale,this.x)),this.
y=Math.min(this.height-e,Math.max(e-this.paper[1]*this.scale,this.y))}};var kr=[["cells","Voronoi cells"],["axes","Axes"],["flow","Flow of the picture"]],xr=300;function Bt(r,e){let{appearance:t}=r;return m("div",
{class:"panel"},m("h2",{},"Beneath"),Ut("Shown",t.under,[["picture","picture"],["tone","tone"],["importance","importance"],["none","nothing"]]),
Er("Opacity",t.opacity),m("h2",{},"Over it"),...kr.map(([n,i])=>Tr(r,n,i,e)),ke("Edge, margin and canvas",t.guides),ke("Rulers",t.rulers),m(
"h2",{},"Page"),Ut("Colours",t.theme,[["system","as the system"],["light","light"],["dark","dark"]]),ke("Shortcuts of one character",t.keys))}
function Ut(r,e,t){let n=m("select",{id:x("view"),change:()=>e.value=n.value},...t.map(([i,o])=>m("option",{value:i},o)));return e.on(i=>n.value=
i),m("div",{class:"knob"},m("label",{for:n.id},r),m("div",{class:"knob-inputs"},n))}function Er(r,e){let t=m("input",{type:"range",id:x("vie\
w"),min:0,max:1,step:.01,input:()=>e.value=t.valueAsNumber});return e.on(n=>t.value=String(n)),m("div",{class:"knob"},m("label",{for:t.id},r),
m("div",{class:"knob-inputs"},t))}function ke(r,e){let t=m("input",{type:"checkbox",id:x("view"),change:()=>e.value=t.checked});return e.on(
n=>t.checked=n),m("div",{class:"knob knob-flag"},t,m("label",{for:t.id},r))}function Tr(r,e,t,n){let i=new L(!1),o=-1,s=!1,a,l=async()=>{let u=r.
drawing.state.value;!i.value||s||!u||u.revision===o||u.busy&&!u.busy.paused||(s=!0,o=u.revision,await r.ask({do:"show",what:e,...r.layer.value===
null?{}:{layer:r.layer.value}})||(i.value=!1),s=!1,i.value||n(e))},c=()=>{clearTimeout(a),a=setTimeout(()=>{l()},xr)};return i.on(u=>{o=-1,u?
l():n(e)}),r.drawing.hello.on(()=>o=-1),r.drawing.changed.on(c),ke(t,i)}var Lr=400;function zt(r){let e=w("work"),t=m("span",{}),n=m("progress",{"aria-label":"Progress"}),i=M("Pause",()=>{r.ask({do:r.drawing.state.
value?.busy?.paused?"resume":"pause"})}),o=M("Cancel",()=>{r.ask({do:r.drawing.state.value?.busy?.single?"cancel":"stop"})}),s=m("small",{},
"Brushes wait until it is done.");e.append(m("div",{},t,s),n,i,o);let a,l=null,c=u=>$(u.replace(/^redraw /,""));r.drawing.state.on(u=>{let h=u?.
busy??null;(h?.n??null)!==l&&(clearTimeout(a),e.hidden=!0,l=h?.n??null,n.removeAttribute("value"),h&&(t.textContent=c(h.op),a=setTimeout(()=>e.
hidden=!1,Lr))),h&&(i.textContent=h.paused?"Go on":"Pause",o.textContent=h.single?"Cancel":"Stop",s.hidden=!h.single)}),r.drawing.steps.on(u=>{
let h=r.drawing.state.value?.busy;if(!h||u.n!==h.n)return;let d=u.total?`${u.done} of ${u.total}`:`${u.done}`;t.textContent=`${c(h.op)}${u.stage===
h.op?"":`: ${u.stage}`} ${d}`,u.total?n.value=u.done/u.total:n.removeAttribute("value")})}function Fe(r,e){if(!("transferControlToOffscreen"in HTMLCanvasElement.prototype)){document.body.textContent="The editor needs a browser tha\
t paints in a thread of its own: Chromium 69, Firefox 105, Safari 16.4, or newer.";return}let t=new Worker(r),n=(h,d=[])=>t.postMessage(h,d),
i=new L(null);t.addEventListener("message",h=>i.value=h.data);let o=new pe;t.addEventListener("error",h=>o.error(`The painter has failed: ${h.
message}. Load the page again; nothing is lost.`));let s=new de(e),a=new le(s,new ue(s,n),new J,new Me,o,new re),l=new fe(a);xt(a);let c=It(
[{name:"Tool",panel:Dt(a)},{name:"Layers",panel:ht(a)},{name:"Relax",panel:Tt(a)},{name:"Style",panel:Ct(a)},{name:"History",panel:lt(a)},{name:"\
View",panel:Bt(a,h=>n({do:"forget",what:h}))}]);a.tool.on(()=>c("Tool")),Nt(a),At(a,n),zt(a),st(a,kt(a,l,new ye(a)));let u="";a.drawing.begun(
h=>a.tools.value=Rt(a,h.operations)),a.drawing.hello.on(h=>{if(!h)return;let d=JSON.stringify([h.name,h.size,h.art]);d!==u&&(a.region.value=
null),u.startsWith(JSON.stringify([h.name]).slice(0,-1))||(a.layer.value=null),u||Sr(a),u=d;for(let p of h.notes)o.note(p)}),s.lost.on(h=>o.
error(h)),Object.assign(window,{crowquill:{desk:a,painted:i}}),Ar(a).finally(()=>s.connect())}function Sr(r){let e=!1;r.drawing.changed.on(()=>{
let{marks:t,undo:n,redo:i}=r.drawing.state.value;!e&&!t&&!n.length&&!i.length&&r.messages.note("Draw with a brush, or let a style draw it al\
l: the panel Style."),e=!0})}async function Ar(r){let e=await r.link.wire.get("libraries.json");e&&(r.libraries=JSON.parse(await e.text()))}var ee=-1,Ft=128,te=class{constructor(e,t,n){this.side=n;this.columns=Math.max(1,Math.ceil(e/n)),this.rows=Math.max(1,Math.ceil(t/n)),this.head=
new Int32Array(this.columns*this.rows).fill(ee)}side;columns;rows;head;next=new Int32Array(1024);back=new Int32Array(1024);column(e){return Math.
min(this.columns-1,Math.max(0,Math.floor(e/this.side)))}row(e){return Math.min(this.rows-1,Math.max(0,Math.floor(e/this.side)))}cell(e,t){return this.
row(t)*this.columns+this.column(e)}add(e,t){if(e>=this.next.length){let i=2**Math.ceil(Math.log2(e+1));this.next=I(this.next,new Int32Array(
i)),this.back=I(this.back,new Int32Array(i))}let n=this.head[t];this.next[e]=n,this.back[e]=~t,n!==ee&&(this.back[n]=e),this.head[t]=e}remove(e){
let t=this.next[e],n=this.back[e];n<0?this.head[~n]=t:this.next[n]=t,t!==ee&&(this.back[t]=n)}clear(){this.head.fill(ee)}within(e,t,n,i,o){let s=0;
for(let a=this.row(t);a<=this.row(i);a++)for(let l=this.column(e);l<=this.column(n);l++)for(let c=this.head[a*this.columns+l];c!==ee;c=this.
next[c])s===o.ids.length&&(o.ids=I(o.ids,new Int32Array(2*s))),o.ids[s++]=c;return s}};var xe=class{items=new F;kinds=new Map;layers=[];width=1;height=1;lines=new Map;grids=new Map;reaches=new Map;changed=new te(1,1,1);stale=new Uint8Array(
1);cells=new Int32Array(0);homes=new Uint32Array(0);begin(e,t){if(this.lines.clear(),this.width===e*1e3&&this.height===t*1e3)return this.touchAll();
this.width=e*1e3,this.height=t*1e3,this.changed=this.grid(),this.stale=new Uint8Array(this.changed.columns*this.changed.rows),this.reset()}reset(){
this.items.clear(),this.cells.fill(-1),this.homes.fill(0),this.kinds.clear(),this.grids.clear(),this.reaches.clear(),this.stale.fill(1)}know(e){
e.some(t=>this.kinds.has(t.id))&&this.stale.fill(1);for(let t of e)this.kinds.set(t.id,new Y(t.d,t.closed,t.reach))}list(e){let t=i=>JSON.stringify(
i.map(o=>[o.id,o.rgb,o.pen,o.hidden])),n=t(e)!==t(this.layers);return this.layers=e,n&&this.stale.fill(1),n}take(e){if(e.type==="lines"&&(this.
lines.set(e.lines.what,new We(e.lines,this.grid())),this.stale.fill(1)),e.type==="items")for(let t of e.chunks)this.change(t)}change(e){let{
items:t,changed:n,stale:i}=this;t.take(e),t.layer.length>this.cells.length&&(this.cells=I(this.cells,new Int32Array(t.layer.length).fill(-1,
this.cells.length)),this.homes=I(this.homes,new Uint32Array(t.layer.length)));let{cells:o,homes:s}=this,a=this.gridOf(e.layer);for(let l=0;l<
e.n;l++){let c=F.id(e,l),u=o[c],h=e.gone?-1:n.cell(t.x[c],t.y[c]);u>=0&&(i[u]=1),h>=0&&(i[h]=1),!(u===h&&s[c]===e.layer)&&(u>=0&&this.gridOf(
s[c]).remove(c),h>=0&&a.add(c,h),o[c]=h,s[c]=e.layer)}!e.gone&&(e.scale||e.kind||e.fill)&&this.reach(e)}reach(e){let t=this.reaches.get(e.layer)??
0;for(let n=0;n<e.n;n++)t=Math.max(t,this.reachOf(F.id(e,n)));this.reaches.set(e.layer,t)}forget(e){this.lines.delete(e)&&this.stale.fill(1)}reachOf(e){
return(this.kinds.get(this.items.kind[e])?.reach??1)*this.items.scale[e]}within(e,t,n,i,o,s){let a=this.grids.get(e),l=this.margin(e);return a?
a.within(t-l,n-l,i+l,o+l,s):0}changedWithin(e,t,n,i){let o=Math.max(0,...this.layers.map(l=>this.margin(l.id))),{changed:s,stale:a}=this;for(let l=s.
row(t-o);l<=s.row(i+o);l++){let c=l*s.columns;for(let u=c+s.column(e-o);u<=c+s.column(n+o);u++)if(a[u])return!0}return!1}settle(){this.stale.
fill(0)}touchWithin(e,t,n,i){let{changed:o,stale:s}=this;for(let a=o.row(t);a<=o.row(i);a++)s.fill(1,a*o.columns+o.column(e),a*o.columns+o.column(
n)+1)}touchAll(){this.stale.fill(1)}margin(e){let t=this.layers.find(n=>n.id===e)?.pen??0;return(this.reaches.get(e)??0)+500*t}gridOf(e){let t=this.
grids.get(e);return t||this.grids.set(e,t=this.grid()),t}grid(){return new te(this.width,this.height,Math.max(this.width,this.height)/Ft)}},
We=class{constructor(e,t){this.set=e;this.grid=t;let[n,i]=Pr(e),o=new Uint32Array(t.columns*t.rows+1);this.cells(n,i,a=>o[a+1]++);for(let a=1;a<
o.length;a++)o[a]+=o[a-1];this.start=o.slice(),this.pieces=new Uint32Array(this.start[this.start.length-1]),this.ends=new Uint32Array(this.pieces.
length);let s=o;this.cells(n,i,(a,l)=>{this.pieces[s[a]]=n[l],this.ends[s[a]++]=i[l]})}set;grid;start;pieces;ends;within(e,t,n,i,o){let{grid:s,
set:a}=this;for(let l=s.row(t);l<=s.row(i);l++)for(let c=s.column(e);c<=s.column(n);c++){let u=l*s.columns+c;for(let h=this.start[u];h<this.
start[u+1];h++){let[d,p]=[2*this.pieces[h],2*this.ends[h]];o(a.xy[d],a.xy[d+1],a.xy[p],a.xy[p+1])}}}cells(e,t,n){let{grid:i,set:o}=this;for(let s=0;s<
e.length;s++){let[a,l]=[1e3*o.xy[2*e[s]],1e3*o.xy[2*e[s]+1]],[c,u]=[1e3*o.xy[2*t[s]],1e3*o.xy[2*t[s]+1]];for(let h=i.row(Math.min(l,u));h<=i.
row(Math.max(l,u));h++)for(let d=i.column(Math.min(a,c));d<=i.column(Math.max(a,c));d++)n(h*i.columns+d,s)}}};function Pr(r){let e=[],t=[];for(let n=0;n+
1<r.start.length;n++){let[i,o]=[r.start[n],r.start[n+1]];for(let s=i;s+1<o;s++)e.push(s),t.push(s+1);r.closed&&o-i>2&&(e.push(o-1),t.push(i))}
return[Uint32Array.from(e),Uint32Array.from(t)]}var Q=class{width=0;height=0;left=0;top=0;sums=new Float32Array(4096);over(e,t,n,i){this.left=e,this.top=t,this.width=n,this.height=i;let o=(n+
2)*i;o>this.sums.length?this.sums=new Float32Array(2*o):this.sums.fill(0,0,o)}fill(e,t){let n=t.x-this.left,i=t.y-this.top;for(let{xy:o}of e){
let s=o.length,a=n+t.cos*o[s-2]-t.sin*o[s-1],l=i+t.sin*o[s-2]+t.cos*o[s-1];for(let c=0;c<s;c+=2){let u=n+t.cos*o[c]-t.sin*o[c+1],h=i+t.sin*o[c]+
t.cos*o[c+1];this.edge(a,l,u,h),a=u,l=h}}}stroke(e,t,n){let i=Math.max(n,.05)/2,o=(s,a)=>[t.x-this.left+t.cos*s[a]-t.sin*s[a+1],t.y-this.top+
t.sin*s[a]+t.cos*s[a+1]];for(let{xy:s,closed:a}of e){let l=s.length;for(let c=a?0:2;c<l;c+=2){let[u,h]=o(s,(c+l-2)%l),[d,p]=o(s,c);this.capsule(
u,h,d,p,i)}l===2&&this.capsule(...o(s,0),...o(s,0),i)}}capsule(e,t,n,i,o){let s=o<.6?1:o<2?4:8,a=Math.atan2(i-t,n-e),l=[];for(let[c,u,h]of[[
n,i,a-Math.PI/2],[e,t,a+Math.PI/2]])for(let d=0;d<=s;d++){let p=h+Math.PI*d/s;l.push(c+o*Math.cos(p),u+o*Math.sin(p))}for(let c=0,u=l.length-
2;c<l.length;u=c,c+=2)this.edge(l[u],l[u+1],l[c],l[c+1])}edge(e,t,n,i){if(t===i)return;let o=1;if(t>i&&([e,t,n,i]=[n,i,e,t],o=-1),i<=0||t>=this.
height)return;let s=(n-e)/(i-t);t<0&&(e-=t*s,t=0),i>this.height&&(n-=(i-this.height)*s,i=this.height);let a=this.width,l=c=>(e-c)*(n-c)<0;if(l(
0))return this.twice(e,t,n,i,0,s,o);if(l(a))return this.twice(e,t,n,i,a,s,o);e>=a&&n>=a||(e<=0&&n<=0?this.rows(0,t,i,0,o):this.rows(e,t,i,s,
o))}twice(e,t,n,i,o,s,a){let l=t+(o-e)/s;a>0?(this.edge(e,t,o,l),this.edge(o,l,n,i)):(this.edge(n,i,o,l),this.edge(o,l,e,t))}rows(e,t,n,i,o){
let s=this.width+2,a=this.sums,l=e;for(let c=Math.floor(t);c<n;c++){let u=Math.max(t,c),d=Math.min(n,c+1)-u;if(d<=0)continue;let p=l+i*d,f=o*
d,[g,v]=l<p?[l,p]:[p,l],y=Math.floor(g),T=Math.ceil(v),E=c*s+y;if(T<=y+1){let k=(g+v)/2-y;a[E]+=f*(1-k),a[E+1]+=f*k}else{let k=1/(v-g),H=1-(g-
y),S=.5*k*H*H,R=v-T+1,N=.5*k*R*R;if(a[E]+=f*S,T===y+2)a[E+1]+=f*(1-S-N);else{let G=k*(1.5-(g-y));a[E+1]+=f*(G-S);for(let O=y+2;O<T-1;O++)a[c*
s+O]+=f*k;let D=G+(T-y-3)*k;a[c*s+T-1]+=f*(1-D-N)}a[c*s+T]+=f*N}l=p}}bytes(e){let t=this.width*this.height,n=e&&e.length>=t?e:new Uint8Array(
t),i=0;for(let o=0;o<this.height;o++){let s=0,a=o*(this.width+2);for(let l=0;l<this.width;l++)s+=this.sums[a+l],n[i++]=Math.min(1,Math.abs(s))*
255+.5|0}return n}};var Gt=6,Wt=48,Ve=1/64,Vt=16,W=4,Cr=24e6,Ee=new Q,je=class{constructor(e,t,n,i){this.outline=e;this.reach=t;this.pen=n;this.weigh=i;this.turns=
Math.max(1,Math.ceil(t*13))}outline;reach;pen;weigh;turns;kept=[];at(e,t,n){let{turns:i}=this,o=Math.round(n/(2*Math.PI)*i)%i,s=Math.min(W-1,
e*W|0),a=Math.min(W-1,t*W|0),l=(o*W+a)*W+s;return this.kept[l]??(this.kept[l]=this.made(s,a,o/i*2*Math.PI))}made(e,t,n){let i=Ir(this.outline,
(e+.5)/W,(t+.5)/W,this.reach/this.outline.reach,n,this.pen);return this.weigh(i.values.length+100),i}},Te=class{kept=new Map;bytes=0;of(e,t,n){
this.bytes>Cr&&(this.kept.clear(),this.bytes=0);let i=Math.round(Math.log2(Math.max(Ve,t*e.reach)/Ve)*Wt),o=Math.round(n*Vt),s=Ge(this.kept,
o,()=>new Map),a=Ge(s,e,()=>new Map);return Ge(a,i,()=>new je(e,Ve*2**(i/Wt),o/Vt,l=>this.bytes+=l))}};function Ir(r,e,t,n,i,o){let s=Math.ceil(
r.reach*n+o/2+1),a=2*s+1;Ee.over(-s,-s,a,a);let l={x:e,y:t,cos:n*Math.cos(i),sin:n*Math.sin(i)};return o>0?Ee.stroke(r.rings(n),l,o):Ee.fill(
r.rings(n),l),Dr(Ee.bytes(),a,-s)}function Dr(r,e,t){let[n,i,o,s]=[e,e,0,0];for(let u=0;u<e;u++)for(let h=0;h<e;h++)r[u*e+h]&&([n,i,o,s]=[Math.
min(n,h),Math.min(i,u),Math.max(o,h+1),u+1]);let[a,l]=[Math.max(0,o-n),Math.max(0,s-i)],c=new Uint8Array(a*l);for(let u=0;u<l;u++)c.set(r.subarray(
(i+u)*e+n,(i+u)*e+o),u*a);return{left:t+n,top:t+i,width:a,height:l,values:c}}function Ge(r,e,t){let n=r.get(e);return n===void 0&&r.set(e,n=
t()),n}var b=256,Rr=2*Math.PI/65536,Ze=new Uint8Array(new Uint32Array([1]).buffer)[0]===1,ne=class{values=new Uint8Array(b*b);left=b;top=b;right=0;bottom=0;get touched(){
return this.left<this.right}clear(){for(let e=this.top;e<this.bottom;e++)this.values.fill(0,e*b+this.left,e*b+this.right);this.left=this.top=
b,this.right=this.bottom=0}blend(e,t,n,i,o){let s=Math.max(0,-t),a=Math.min(i,b-t),l=Math.max(0,-n),c=Math.min(o,b-n);if(s>=a||l>=c)return;t+
s<this.left&&(this.left=t+s),n+l<this.top&&(this.top=n+l),t+a>this.right&&(this.right=t+a),n+c>this.bottom&&(this.bottom=n+c);let{values:u}=this;
for(let h=l;h<c;h++){let d=(n+h)*b+t+s,p=h*i+a;for(let f=h*i+s;f<p;f++,d++){let g=e[f];if(g){let v=u[d];u[d]=v+((255-v)*g*257+32896>>16)}}}}line(e,t,n,i){
let o=Math.abs(i-t)>Math.abs(n-e);o&&([e,t,n,i]=[t,e,i,n]),e>n&&([e,t,n,i]=[n,i,e,t]);let s=n>e?(i-t)/(n-e):0,[a,l]=[Math.max(0,Math.floor(e)),
Math.min(b-1,Math.floor(n))];for(let c=a;c<=l;c++){let u=t+s*(Math.min(n,Math.max(e,c+.5))-e)-.5,h=Math.floor(u),d=u-h;this.most(o?h:c,o?c:h,
255*(1-d)),this.most(o?h+1:c,o?c:h+1,255*d)}this.left=this.top=0,this.right=this.bottom=b}most(e,t,n){if(e<0||t<0||e>=b||t>=b)return;let i=t*
b+e;n>this.values[i]&&(this.values[i]=n)}},Le=class{image=new ImageData(b,b);data=this.image.data;words=new Uint32Array(this.data.buffer);ink=new ne;selected=new ne;frozen=new ne;sprites=new Te;coverage=new Q;patch=new Uint8Array(
4096);found={ids:new Int32Array(4096)};paint(e,t,n,i,o,s){this.words.set(s(null));let a=1e3/t,[l,c]=[n*b*a,i*b*a];for(let u of e.layers){if(u.
hidden)continue;if(u.kind==="still"){this.cover(s(u.id));continue}let h=e.within(u.id,l,c,l+b*a,c+b*a,this.found);h&&this.layer(e,u,h,t,n*b,
i*b),this.lay(this.ink,u.rgb),this.lay(this.frozen,o.frozen),this.lay(this.selected,o.selected)}for(let u of e.lines.values())u.within(l,c,l+
b*a,c+b*a,(h,d,p,f)=>this.ink.line(h*t-n*b,d*t-i*b,p*t-n*b,f*t-i*b)),this.lay(this.ink,o.lines);return this.image}layer(e,t,n,i,o,s){let{items:a}=e,
l=i/1e3,c=[];for(let u=0;u<n;u++){let h=this.found.ids[u],d=a.kind[h],p=c[d];if(!p||p.scale!==a.scale[h]){let D=e.kinds.get(d);if(!D)continue;
p=c[d]=this.look(D,a.scale[h],l,t)}let{outline:f,size:g,pen:v,far:y,family:T}=p,E=a.x[h]*l-o,k=a.y[h]*l-s;if(E+y<0||k+y<0||E-y>=b||k-y>=b)continue;
let H=a.flags[h],S=a.fill[h],R=H&1?this.selected:H&2?this.frozen:this.ink,N=S>=16777216&&R===this.ink;N&&this.lay(this.ink,t.rgb);let G=a.turn[h]*
Rr;if(T){let D=Math.floor(E),O=Math.floor(k),U=T.at(E-D,k-O,G);R.blend(U.values,D+U.left,O+U.top,U.width,U.height)}else{let[D,O]=[Math.max(0,
Math.floor(E-y)),Math.max(0,Math.floor(k-y))],[U,qe]=[Math.min(b,Math.ceil(E+y)),Math.min(b,Math.ceil(k+y))];this.coverage.over(D,O,U-D,qe-O);
let Xe={x:E,y:k,cos:g*Math.cos(G),sin:g*Math.sin(G)};v>0?this.coverage.stroke(f.rings(g),Xe,v):this.coverage.fill(f.rings(g),Xe),this.patch=
this.coverage.bytes(this.patch),R.blend(this.patch,D,O,U-D,qe-O)}N&&this.lay(this.ink,[S>>16&255,S>>8&255,S&255])}}look(e,t,n,i){let o=t*n,s=i.
pen===null?e.closed?0:1:Math.max(i.pen*n*1e3,.1),a=e.reach*o;return{outline:e,scale:t,size:o,pen:s,far:a+s/2+1,family:a<=Gt?this.sprites.of(
e,o,s):null}}cover(e){if(!e)return;let{words:t}=this,n=new Uint8ClampedArray(e.buffer);for(let i=0;i<e.length;i++){let o=e[i]&&n[4*i+3];o===
255||o&&!t[i]?t[i]=e[i]:o&&this.mix(4*i,n[4*i],n[4*i+1],n[4*i+2],o)}}mix(e,t,n,i,o){let{data:s}=this,l=s[e+3]*(255-o)/255,c=o+l;s[e]=(t*o+s[e]*
l)/c,s[e+1]=(n*o+s[e+1]*l)/c,s[e+2]=(i*o+s[e+2]*l)/c,s[e+3]=c}lay(e,t){if(!e.touched)return;let{words:n}=this,[i,o,s]=t,a=Ze?i|o<<8|s<<16:i<<
24|o<<16|s<<8,{values:l}=e;for(let c=e.top;c<e.bottom;c++)for(let u=c*b+e.left;u<c*b+e.right;u++){let h=l[u];if(!h)continue;let d=n[u];if(h===
255||!d)n[u]=Ze?a|h<<24:a|h;else if(Ze&&d>=4278190080){let[p,f,g]=[d&255,d>>8&255,d>>16&255],v=h*257,y=p+((i-p)*v+32896>>16)|f+((o-f)*v+32896>>
16)<<8;n[u]=y|g+((s-g)*v+32896>>16)<<16|4278190080}else this.mix(4*u,i,o,s,h)}e.clear()}};var Nr={tone:r=>[32,32,32,r],importance:r=>r>127?[120,30,170,Math.min(255,(r-127)*2)]:[0,120,60,(127-r)*2]},Se=class{version=0;images=new Map;scratch=new OffscreenCanvas(
b,b);size=[1,1];art=[0,0,1,1];show(e,t){this.version++,this.images.delete(e),t&&this.images.set(e,$r(t))}forgetMaps(){this.version++,this.images.
delete("tone"),this.images.delete("importance")}take(e){this.version++;let t=this.images.get(e.map)?.[0],i=t instanceof OffscreenCanvas&&t.width===
e.columns&&t.height===e.rows?t:new OffscreenCanvas(e.columns,e.rows),o=new ImageData(e.width,e.height);for(let f=0;f<e.values.length;f++)o.data.
set(Nr[e.map](e.values[f]),4*f);i.getContext("2d").putImageData(o,e.left,e.top),this.images.set(e.map,[i]);let[s,a,l,c]=this.art.map(f=>f*1e3),
[u,h]=[l/e.columns,c/e.rows],[d,p]=[s+(e.left-1)*u,a+(e.top-1)*h];return[d,p,d+(e.width+2)*u,p+(e.height+2)*h]}pixels(e,t,n,i,o){if(e!==null&&
!this.images.has(e))return null;let s=this.scratch.getContext("2d",{willReadFrequently:!0}),[a,l]=this.size;return s.clearRect(0,0,b,b),e===
null?(s.fillStyle=o.paper,s.fillRect(-n,-i,a*t,l*t),this.lay(s,o.under,this.art,t,n,i,o.opacity)):this.lay(s,e,[0,0,a,l],t,n,i,1),new Uint32Array(
s.getImageData(0,0,b,b).data.buffer)}lay(e,t,n,i,o,s,a){let l=this.images.get(t);if(!l||!a)return;let c=n[2]*i,u=l.findLast(h=>h.width>=c)??
l[0];e.globalAlpha=a,e.imageSmoothingEnabled=c<8*u.width,e.drawImage(u,n[0]*i-o,n[1]*i-s,c,n[3]*i),e.globalAlpha=1}};function $r(r){let e=[r];
for(let t=r;Math.min(t.width,t.height)>128;){let n=new OffscreenCanvas(Math.ceil(t.width/2),Math.ceil(t.height/2));n.getContext("2d").drawImage(
t,0,0,n.width,n.height),e.push(t=n)}return e}var Kr=14,Ur=24,Br=60,zr=70,Fr=160,Wr=40,Ye=class{scene=new xe;underlay=new Se;tilePainter=new Le;spare=[];canvas=null;look=null;view={scale:1,
x:0,y:0};tiles={scale:0,all:new Map};before=null;zoomed=0;asked=!1;moved=!0;drawn=0;frames=0;coming=0;missing=0;revision=0;shown=0;take(e){switch(e.
do){case"canvas":this.canvas=e.canvas;break;case"begin":this.scene.begin(...e.size),[this.underlay.size,this.underlay.art]=[e.size,e.art];break;case"\
state":e.reset&&(this.scene.reset(),this.underlay.forgetMaps()),this.scene.know(e.kinds),this.scene.list(e.layers),this.coming=e.revision,this.
missing=e.frames,this.arrive();break;case"frame":this.receive(e.buffer);break;case"view":this.see(e.view,e.width,e.height);break;case"look":
this.look=e.look,this.moved=!0,this.underlay.version++,this.scene.touchAll();break;case"image":this.underlay.show(e.name,e.bitmap),this.scene.
touchAll();break;case"forget":this.scene.forget(e.what)}this.ask()}receive(e){let t=ce(e);if(t.type==="raster")for(let n of t.patches)this.scene.
touchWithin(...this.underlay.take(n));else this.scene.take(t);t.type!=="lines"&&(this.missing--,this.arrive())}arrive(){this.missing<=0&&(this.
revision=this.coming)}see(e,t,n){this.canvas&&(this.canvas.width!==t||this.canvas.height!==n)&&([this.canvas.width,this.canvas.height]=[t,n]),
e.scale!==this.view.scale&&(this.zoomed=performance.now()),this.view=e,this.moved=!0}ask(){this.asked||(this.asked=!0,requestAnimationFrame(
()=>this.frame()))}frame(){this.asked=!1;let e=this.canvas?.getContext("2d",{alpha:!1});if(!e||!this.look)return;let t=performance.now(),n=t-
this.zoomed>zr||!this.tiles.all.size;n&&this.tiles.scale!==this.view.scale&&this.change(),this.mark();let i=n?this.make(t+(this.moved?Kr:Ur)):
1;(!i||this.moved||t-this.drawn>Br)&&(this.draw(e),this.drawn=t,this.moved=!1),i?this.ask():(this.before=this.drop(this.before),this.shown=this.
revision),this.frames++;let o=performance.now(),s={revision:this.shown,frames:this.frames,cost:o-t,at:performance.timeOrigin+o};postMessage(
s)}change(){[...this.tiles.all.values()].some(t=>t.canvas)&&(this.drop(this.before),this.before=this.tiles),this.tiles={scale:this.view.scale,
all:new Map}}mark(){let e=b*1e3/this.tiles.scale;for(let t of this.tiles.all.values()){if(!t.fresh)continue;let[n,i]=[t.column*e,t.row*e];t.
fresh=!this.scene.changedWithin(n,i,n+e,i+e)}this.scene.settle()}make(e){let t=this.inSight().filter(l=>!l.fresh),{canvas:n,view:i}=this,[o,
s]=[(n.width/2-i.x)/b-.5,(n.height/2-i.y)/b-.5];t.sort((l,c)=>Math.hypot(l.column-o,l.row-s)-Math.hypot(c.column-o,c.row-s));let a=0;for(let l of t)
if(this.paint(l),a++,performance.now()>e)break;return this.forget(),t.length-a}paint(e){let{scale:t}=this.tiles,[n,i]=[e.column*b,e.row*b];e.
version!==this.underlay.version&&e.grounds.clear(),e.version=this.underlay.version;let o=a=>{let l=e.grounds.get(a);return l===void 0&&e.grounds.
set(a,l=this.underlay.pixels(a,t,n,i,this.look)),l},s=this.tilePainter.paint(this.scene,t,e.column,e.row,this.look.tints,o);e.canvas??=this.
spare.pop()??new OffscreenCanvas(b,b),e.canvas.getContext("2d",{willReadFrequently:!0}).putImageData(s,0,0),e.fresh=!0}inSight(){let{view:e,
tiles:t,canvas:n,scene:i}=this;if(t.scale!==e.scale)return[];let o=(a,l,c)=>Math.floor(Math.min(a/1e3*e.scale+8,l-c)/b),s=[];for(let a=Math.
max(-1,Math.floor(-e.y/b));a<=o(i.height,n.height,e.y);a++)for(let l=Math.max(-1,Math.floor(-e.x/b));l<=o(i.width,n.width,e.x);l++){let c=(a+
1)*1e6+l+1,u=t.all.get(c);u||t.all.set(c,u={column:l,row:a,canvas:null,fresh:!1,grounds:new Map,version:-1}),s.push(u)}return s}forget(){if(this.
tiles.all.size<=Fr)return;let e=new Set(this.inSight());for(let[t,n]of this.tiles.all)e.has(n)||(this.free(n),this.tiles.all.delete(t))}draw(e){
let{view:t,look:n,scene:i}=this,{width:o,height:s}=e.canvas;e.fillStyle=n.desk,e.fillRect(0,0,o,s);let[a,l]=[Math.round(t.x),Math.round(t.y)];
e.fillStyle=n.paper,e.fillRect(a,l,i.width/1e3*t.scale,i.height/1e3*t.scale);for(let c of[this.before,this.tiles]){if(!c)continue;let u=t.scale/
c.scale,h=b*u;for(let{column:d,row:p,canvas:f}of c.all.values()){let[g,v]=[a+d*h,l+p*h];!f||g>=o||v>=s||g+h<=0||v+h<=0||(u===1?e.drawImage(f,
g,v):e.drawImage(f,g,v,h,h))}}}drop(e){for(let t of e?.all.values()??[])this.free(t);return null}free(e){e.canvas&&this.spare.length<Wr&&this.
spare.push(e.canvas),e.canvas=null}};function jt(){let r=new Ye;addEventListener("message",e=>r.take(e.data))}function Zt(){return{open(){let r=new WebSocket(new URL("socket",location.href.replace(/^http/,"ws")));return r.binaryType="arraybuffer",r},
async get(r){let e=await fetch(new URL(r,location.href));return e.ok?e.blob():null},ended:"The server has ended. All is saved: start crowqui\
ll edit again and open the address that it prints."}}var Je=class extends EventTarget{constructor(t){super();this.tell=t;queueMicrotask(()=>t(
{open:!0}))}tell;readyState=WebSocket.CONNECTING;send(t){this.tell({text:t})}hear(t){this.readyState===WebSocket.CONNECTING&&(this.readyState=
WebSocket.OPEN,this.dispatchEvent(new Event("open"))),this.dispatchEvent(new MessageEvent("message",{data:t}))}close(t=1e3){this.readyState=
WebSocket.CLOSED,this.dispatchEvent(new CloseEvent("close",{code:t}))}};function Yt(r){let e=null,t=new Map,n=i=>r.postMessage(i);return r.onmessage=
({data:i})=>{if("text"in i)e?.hear(i.text);else if("frame"in i)e?.hear(i.frame);else if("closed"in i)e?.close(i.closed);else{for(let o of t.
get(i.got)??[])o(i.data&&new Blob([i.data],{type:i.type}));t.delete(i.got)}},{open:()=>e=new Je(n),get:i=>new Promise(o=>{t.set(i,[...t.get(
i)??[],o]),n({get:i})}),ended:"The kernel has ended, and the editor with it: run the cell again."}}if(typeof document>"u")jt();else{let r=document.currentScript;if(r.src)Fe(r.src,Zt());else{let e=URL.createObjectURL(new Blob([r.textContent??
""],{type:"text/javascript"}));window.addEventListener("message",t=>t.ports[0]&&Fe(e,Yt(t.ports[0])),{once:!0})}}})();
