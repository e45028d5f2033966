"use strict";(()=>{var P=class{listeners=new Set;on(e){this.listeners.add(e)}say(e){for(let t of[...this.listeners])t(e)}},T=class{constructor(e){this.now=e}now;changed=new P;get value(){
return this.now}set value(e){Object.is(e,this.now)||(this.now=e,this.changed.say(e))}on(e){e(this.now),this.changed.on(e)}};function z(r,e){
let t=`crowquill ${r}`,n=new T(e);try{let o=JSON.parse(localStorage.getItem(t)??"null");typeof o==typeof e&&(n.value=o)}catch{}return n.on(o=>{
try{localStorage.setItem(t,JSON.stringify(o))}catch{}}),n}var Vt=.5,ne=class{theme=z("theme","system");under=z("under","picture");instead=new T(null);opacity=z("opacity",.25);rulers=z("rulers",!0);guides=z(
"guides",!0);keys=z("keys",!0);changed=new P;constructor(){let e=matchMedia("(prefers-color-scheme: dark)"),t=()=>{let n=this.theme.value===
"dark"||this.theme.value==="system"&&e.matches;document.documentElement.dataset.theme=n?"dark":"light",this.changed.say()};this.theme.on(t),
e.addEventListener("change",t);for(let n of[this.under,this.instead,this.opacity,this.rulers,this.guides])n.on(()=>this.changed.say())}flip(){
this.theme.value=document.documentElement.dataset.theme==="dark"?"light":"dark"}colour(e){return getComputedStyle(document.documentElement).
getPropertyValue(`--${e}`).trim()}get look(){let{instead:e,under:t,opacity:n}=this,o={selected:Te(this.colour("selected")),frozen:Te(this.colour(
"frozen")),lines:Te(this.colour("lines"))};return{...{desk:this.colour("desk"),paper:"#fff",tints:o,under:e.value??t.value},opacity:e.value?
Math.max(n.value,Vt):n.value}}};function Te(r){let e=parseInt(r.slice(1),16);return[e>>16&255,e>>8&255,e&255]}function h(r,e={},...t){let n=document.createElement(r);return R(n,e),n.append(...t.filter(o=>o!=null&&o!==!1)),n}function R(r,e){for(let[t,
n]of Object.entries(e))typeof n=="function"?r.addEventListener(t,n):n==null||n===!1?r.removeAttribute(t):r.setAttribute(t,n===!0?"":String(n))}
var Ft=0;function k(r){return`${r}-${++Ft}`}function w(r){let e=document.getElementById(r);if(!e)throw new Error(`the page has no element ${r}`);
return e}function V(r){let e=document.createElementNS("http://www.w3.org/2000/svg","svg");R(e,{viewBox:"0 0 16 16",class:"icon","aria-hidden":"\
true"});let t=document.createElementNS("http://www.w3.org/2000/svg","path");return R(t,{d:r}),e.append(t),e}function U(r,e,t,n={}){return h(
"button",{type:"button",class:"icon-button","aria-label":e,title:e,click:t,...n},V(r))}function M(r,e,t={}){return h("button",{type:"button",
click:e,...t},r)}var A=(r,e,t)=>`M${r-t} ${e}a${t} ${t} 0 1 0 ${2*t} 0a${t} ${t} 0 1 0 ${-2*t} 0`,D={pick:"M4 2.5 12.5 8 8.7 8.9 6.6 12.6Z",rectangle:"M2.5 5\
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
10"};function F(r,...e){let t=k("dialog"),n=()=>i.close(),o=h("header",{},h("h2",{id:t},r),U(D.cancel,"Close",n)),i=h("dialog",{"aria-labelledby":t},
o,h("div",{class:"dialog-body"},...e)),s=document.activeElement;return i.addEventListener("close",()=>{i.remove(),s instanceof HTMLElement&&
s.focus()}),i.addEventListener("click",a=>a.target===i&&n()),document.body.append(i),i.showModal(),i}var re=1e3,Gt=15,jt=100;function oe(r,e,t,n={}){return r.name==="glyph"?en(r,e,t,n):r.kind==="flag"?Yt(r,e,t):r.kind==="choice"?Jt(r,e,t):r.
kind==="range"?qt(r,e,t):Qt(r,e,t)}var Ge={pdfx:"PDF/X",pdfa:"PDF/A",icc:"ICC profile",dpi:"DPI"},Zt={paper:["a4","a5","letter"]};function $(r){
if(Ge[r])return Ge[r];let e=r.replace(/_/g," ");return e.charAt(0).toUpperCase()+e.slice(1)}function ie(r,e,...t){let n=h("label",{for:e,title:r.
help},$(r.name));return h("div",{class:"knob"},n,h("div",{class:"knob-inputs"},...t))}function Yt(r,e,t){let n=k("knob"),o=h("input",{type:"\
checkbox",id:n,change:()=>t(o.checked)}),i=h("div",{class:"knob knob-flag"},o,h("label",{for:n,title:r.help},$(r.name)));return X(i,e,s=>o.checked=
s===!0)}function Jt(r,e,t){let n=k("knob"),o=r.names??[],i=r.default===null?[h("option",{value:""},"automatic")]:[],s=h("select",{id:n,title:r.
help,change:()=>t(s.value||null)},...i,...o.map(a=>h("option",{value:a},a)));return X(ie(r,n,s),e,a=>s.value=a===null?"":String(a))}function qt(r,e,t){
let n=k("knob"),[o,i]=[r.low??0,r.high??1],s=Xt(o,i,typeof r.default=="number"?r.default:null,r.unit),a=r.whole?1:"any",c=h("input",{type:"n\
umber",id:n,min:o,max:i,step:a,title:r.help,placeholder:r.default===null?"auto":null}),l=h("input",{type:"range",min:0,max:re,tabindex:-1,"a\
ria-hidden":"true",title:r.help}),u=d=>{c.setCustomValidity(""),t(d)};c.addEventListener("input",()=>{if(c.value===""&&!c.validity.badInput)
return t(r.default);c.validity.valid&&(l.value=String(s.to(c.valueAsNumber)*re),u(c.valueAsNumber))}),l.addEventListener("input",()=>{let d=_t(
s.from(Number(l.value)/re),r.whole??!1);c.value=String(d),u(d)});let m=r.unit?h("span",{class:"unit"},r.unit==="deg"?"°":r.unit):null;return X(
ie(r,n,l,c,m),e,d=>{document.activeElement!==c&&(c.value=typeof d=="number"?String(d):""),l.value=String(s.to(typeof d=="number"?d:o)*re)})}
function Xt(r,e,t,n){let o=Math.max(Math.abs(t??0),r,1e-6);if(e<=1||(e-r)/o<Gt)return{to:l=>(l-r)/(e-r),from:l=>r+l*(e-r)};let i=n==="mm"?Math.
min(e,jt):e,s=Math.max(.001,Math.min(t?Math.abs(t):i,i/5)/3),[a,c]=[Math.asinh(r/s),Math.asinh(i/s)];return{to:l=>Math.min(1,(Math.asinh(l/s)-
a)/(c-a)),from:l=>s*Math.sinh(a+l*(c-a))}}function _t(r,e){return e?Math.round(r):Math.abs(r)<.001?0:Number(r.toPrecision(2))}function Qt(r,e,t){
let n=k("knob"),o=r.kind==="numbers",i=Zt[r.name]?.map(c=>h("option",{value:c}))??[],s=i.length?h("datalist",{id:k("known")},...i):null,a=h(
"input",{type:"text",id:n,title:r.help,spellcheck:"false",placeholder:r.default===null?"auto":null,list:s?.id});return a.addEventListener("c\
hange",()=>{let c=a.value.trim(),l=c.split(/[\s,;]+/).map(Number),u=o&&c!==""&&(l.some(Number.isNaN)||r.count!=null&&l.length!==r.count);a.setCustomValidity(
u?`${r.count??"Some"} numbers, parted by commas`:""),u?a.reportValidity():t(c===""?r.default:o?l:c)}),X(ie(r,n,a,s),e,c=>a.value=c===null?"":
Array.isArray(c)?c.join(", "):String(c))}function en(r,e,t,n){let o=k("knob"),i=r.default===null?[h("option",{value:""},"as the layer has")]:
[],s=h("select",{id:o,title:r.help},...i,...Object.keys(n).map(m=>h("option",{value:m},m))),a=h("div",{class:"shapes",role:"group","aria-lab\
el":"Shapes of the library"}),c=m=>{let[d="",p]=typeof m=="string"?m.split("/"):[];s.value=d,a.replaceChildren(...(n[d]??[]).map((f,g)=>l(d,
g,f,String(g)===p))),a.hidden=!d},l=(m,d,p,f)=>{let g=()=>{let v=f?m:`${m}/${d}`;t(v),c(v),a.children[d]?.focus()};return h("button",{type:"\
button","aria-pressed":String(f),"aria-label":`${m} ${d}`,click:g},tn(p))};s.addEventListener("change",()=>{t(s.value||null),c(s.value||null)});
let u=h("div",{},ie(r,o,s),a);return X(u,e,c)}function tn(r){let e=document.createElementNS("http://www.w3.org/2000/svg","svg"),t=document.createElementNS(
"http://www.w3.org/2000/svg","path");return e.setAttribute("viewBox",[-1,-1,2,2].map(n=>1e3*n*r.reach).join(" ")),e.classList.toggle("lines",
!r.closed),e.setAttribute("aria-hidden","true"),t.setAttribute("d",r.d),e.append(t),e}function X(r,e,t){return t(e),{element:r,show:t}}var nn=/\.(pdf|svg)$/,rn=["svg","pdf"];function Se(r){let e=r.drawing.hello.value;if(!e)return;let t=h("input",{type:"text",id:k("export"),value:`${e.
name.replace(/\.[^.]*$/,"")}-edited`,required:!0,spellcheck:"false"}),n=new Map,o=h("div",{class:"knobs"}),i=Object.keys(e.formats).map(m=>{
let d=h("input",{type:"checkbox",id:k("format"),value:m,checked:rn.includes(m),change:()=>a()});return{format:m,box:d,element:h("span",{class:"\
chip"},d,h("label",{for:d.id},m))}}),s=()=>i.filter(m=>m.box.checked).map(m=>m.format),a=()=>o.replaceChildren(...je(e,s()).map(m=>oe(m,n.get(
m.name)??m.default,d=>n.set(m.name,d)).element)),c=h("div",{"aria-live":"polite"}),l=M("Export",()=>{u()},{class:"wide primary"}),u=async()=>{
if(!t.reportValidity()||!s().length)return;let m=new Set(je(e,s()).map(f=>f.name)),d=Object.fromEntries([...n].filter(([f,g])=>m.has(f)&&g!==
null));R(l,{disabled:!0});let p=await Ze(r,c,{do:"export",files:s().map(f=>`${t.value}.${f}`),options:d});R(l,{disabled:!1}),p&&c.replaceChildren(
...(p.files??[]).map(f=>on(r,f)))};a(),F("Export",h("div",{class:"knob"},h("label",{for:t.id},"Name"),h("div",{class:"knob-inputs"},t)),h("d\
iv",{class:"row chips",role:"group","aria-label":"Formats"},...i.map(m=>m.element)),h("details",{},h("summary",{},"Options of these formats"),
o),l,c)}function je(r,e){let t=new Map;for(let n of e)for(let o of r.formats[n]??[])t.has(o.name)||t.set(o.name,o);return[...t.values()]}async function Ze(r,e,t){
try{return(await r.link.ask(t)).facts}catch(n){return e.replaceChildren(h("p",{class:"error"},n.message)),null}}function on(r,e){let t=h("di\
v",{}),n=async()=>{let i=await Ze(r,t,{do:"check",file:e});i&&t.replaceChildren(sn(i.findings??[]))},o=nn.test(e)?M("Preflight",()=>{n()}):null;
return h("div",{class:"written"},h("p",{},h("strong",{},e)," is written"),o,t)}function sn(r){return r.length?h("ul",{class:"findings"},...r.
map(e=>h("li",{class:e.severity},h("strong",{},e.severity),` ${e.message} `,h("small",{},e.where)))):h("p",{},"Nothing stands between it and\
 the press.")}function an(r){let e=r.key.length===1?r.key.toLowerCase():r.key,t=/^[a-z]$/.test(e)||r.key.length>1;return[...[(r.ctrlKey||r.metaKey)&&"Ctrl",
r.altKey&&"Alt",r.shiftKey&&t&&"Shift"].filter(Boolean),e].join("+")}var ln="input:not([type=checkbox]):not([type=radio]):not([type=range]),\
 select, textarea",Pe=new Map,Je;function qe(r,e){Pe.size||window.addEventListener("keydown",cn),Je=e,Pe=new Map(r.flatMap(t=>t.keys.map(n=>[
n,t])))}function cn(r){let e=an(r),t=Pe.get(e);!t||e.length===1&&!Je.value||r.defaultPrevented||document.querySelector("dialog[open]")||r.target instanceof
Element&&r.target.matches(ln)||(r.preventDefault(),t.run(e))}var Ye=[["Wheel","Pan; with Ctrl, or two fingers, zoom"],["Space and drag","Pan\
; so does the middle button"],["Alt and a brush","The other way round: smaller, turned back, thawed"],["Shift, Alt and a selection","Add to \
it, take from it"],["Arrows on the canvas","Move the pointer by 1 mm, with Shift by 10"],["Enter on the canvas","Press the tool where the po\
inter is"]];function Xe(r,e){let t=e.map(s=>[s.shown??s.keys.slice(0,2).map(un).join(" or "),s.about]),n=Math.ceil(t.length/2+Ye.length/2),o=h(
"p",{class:"help"},`crowquill ${r.drawing.hello.value?.version??""}`),i=h("div",{class:"stack"},Ae("More keys",t.slice(n)),Ae("Pointer and p\
en",Ye),o);F("Keys",h("div",{class:"help-sheet"},Ae("Keys",t.slice(0,n)),i)).classList.add("wide-dialog")}function Ae(r,e){let t=e.map(([n,o])=>h(
"tr",{},h("th",{scope:"row"},h("kbd",{},n)),h("td",{},o)));return h("table",{},h("caption",{},r),h("tbody",{},...t))}function un(r){return r.
split(/\+(?=.)/).map(e=>e.length===1?e.toUpperCase():e).join(" ")}async function De(r){let e=await r.ask({do:"files"});if(!e)return;let t=e.facts.files??[],n=async s=>{i.close(),await r.ask({do:"open",file:s})&&
r.messages.note(`${s} is open; every tab shows it.`)},o=h("ul",{class:"files"},...t.map(s=>h("li",{},M(s,()=>{n(s)})))),i=F("Open",t.length?
o:h("p",{},"There is nothing else in the folder that can be opened."))}var hn=96/25.4;function _e(r,e){let t=()=>[...mn(r),...dn(r),...pn(r),...fn(r),...gn(r,e,n)],n=()=>Xe(r,t());r.tools.on(i=>{i.length&&qe(t(),
r.appearance.keys)});let o=[["undo",()=>{r.ask({do:"undo"})}],["redo",()=>{r.ask({do:"redo"})}],["open",()=>{De(r)}],["export",()=>Se(r)],["\
theme",()=>r.appearance.flip()],["help",n],["fit",()=>r.viewport.all()],["zoom",()=>r.viewport.set(hn*r.viewport.ratio)]];for(let[i,s]of o)w(
i).addEventListener("click",s),w(i).classList.contains("icon-button")&&w(i).replaceChildren(V(D[i]));r.drawing.state.on(i=>{for(let[s,a,c,l]of[
["undo",i?.undo,"Undo","Ctrl Z"],["redo",i?.redo,"Do again","Ctrl Shift Z"]])w(s).disabled=!a?.length,w(s).title=`${c}${a?.[0]?`: ${a[0]}`:""}\
 (${l})`})}function mn(r){return r.tools.value.filter(t=>t.key).map(t=>({keys:[t.key],about:t.title,run:()=>r.tool.value=t}))}function dn(r){
let e=()=>!!r.drawing.state.value?.selected,t=o=>()=>{r.apply("select",{by:o})},n=o=>()=>{let i=r.operation("relax");i&&r.apply("relax",{...r.
settings.params(i),...r.ofLayer(i)},{times:o})};return[{keys:["Ctrl+z"],about:"Undo",run:()=>{r.ask({do:"undo"})}},{keys:["Ctrl+Shift+z","Ct\
rl+y"],about:"Do again",run:()=>{r.ask({do:"redo"})}},{keys:["Ctrl+a"],about:"Select all",run:t("all")},{keys:["Ctrl+i"],about:"Invert the s\
election",run:t("invert")},{keys:["Ctrl+d"],about:"Duplicate the selection",run:()=>{e()&&r.apply("duplicate",{})}},{keys:["Delete","Backspa\
ce"],about:"Erase the selection",run:()=>{e()&&r.apply("erase",{on:"selection"})}},{keys:["x"],about:"One step of relaxation",run:n(1)},{keys:[
"Shift+x"],about:"Ten steps of relaxation",run:n(10)}]}function pn(r){let{settings:e}=r,t=o=>()=>{let i=r.tool.value?.operation;i&&e.scale(i,
"size",o)},n=o=>{let i=r.tool.value?.operation;i&&e.set(i,"strength",o==="0"?1:Number(o)/10)};return[{keys:["["],about:"Smaller brush",run:t(
1/1.2)},{keys:["]"],about:"Larger brush",run:t(1.2)},{keys:[..."1234567890"],shown:"1 … 9, 0",about:"Strength 10 … 90, 100 %",run:n}]}function fn(r){
let{viewport:e}=r;return[{keys:["+","="],about:"Closer",run:()=>e.zoom(1.25)},{keys:["-"],about:"Farther",run:()=>e.zoom(1/1.25)},{keys:["Ho\
me"],about:"The whole paper",run:()=>e.all()},{keys:["z"],about:"What is selected, as large as it goes",run:()=>{let n=r.drawing.selection();
n&&e.fit(n)}}]}function gn(r,e,t){return[{keys:["Escape"],about:"Give up the stroke, stop the work, or select nothing",run:()=>{let{busy:o,selected:i}=r.
drawing.state.value??{};e.busy?e.cancel():o?r.ask({do:"stop"}):r.region.value?r.region.value=null:i&&r.apply("select",{by:"none"})}},{keys:[
"Ctrl+o"],about:"Open",run:()=>{De(r)}},{keys:["Ctrl+s"],about:"Export",run:()=>Se(r)},{keys:["Shift+d"],about:"Light or dark",run:()=>r.appearance.
flip()},{keys:["?"],about:"This sheet",run:t}]}var se=class{constructor(e,t,n,o,i,s){this.link=e;this.drawing=t;this.settings=n;this.viewport=o;this.messages=i;this.appearance=s}link;drawing;settings;viewport;messages;appearance;layer=new T(
null);tools=new T([]);tool=new T(null);region=new T(null);libraries={};group=0;operation(e){return this.drawing.hello.value?.operations.find(
t=>t.name===e)}newGroup(){return this.group=Math.max(this.group+1,Date.now())}async apply(e,t,n={}){return this.ask({do:"apply",op:e,params:t,
...n})}async ask(e){try{let t=await this.link.ask(e);for(let n of t.notes??[])this.messages.note(n);return t}catch(t){return this.messages.error(
t.message),null}}ofLayer(e){let t=this.layer.value;return t!==null&&e.knobs.some(n=>n.name==="layer")?{layer:t}:{}}};var G=class{count=0;end=0;layer=new Uint32Array(1024);x=new Int32Array(1024);y=new Int32Array(1024);scale=new Uint32Array(1024);turn=new Uint16Array(
1024);kind=new Uint32Array(1024);fill=new Uint32Array(1024);flags=new Uint8Array(1024);clear(){this.layer.fill(0),this.count=this.end=0}take(e,t,n){
let{ids:o,x:i,y:s,scale:a,turn:c,kind:l,fill:u,flags:m}=e;o.length&&this.reserve(o[o.length-1]+1);for(let d=0;d<o.length;d++){let p=o[d],f=this.
layer[p];if(f&&t&&t(p),e.gone){f&&this.count--,this.layer[p]=0;continue}f||this.count++,this.layer[p]=e.layer,i&&(this.x[p]=i[d]),s&&(this.y[p]=
s[d]),a&&(this.scale[p]=a[d]),c&&(this.turn[p]=c[d]),l&&(this.kind[p]=l[d]),u&&(this.fill[p]=u[d]),m&&(this.flags[p]=m[d]),n&&n(p)}}reserve(e){
if(this.end=Math.max(this.end,e),e<=this.layer.length)return;let t=2**Math.ceil(Math.log2(e));this.layer=O(this.layer,new Uint32Array(t)),this.
x=O(this.x,new Int32Array(t)),this.y=O(this.y,new Int32Array(t)),this.scale=O(this.scale,new Uint32Array(t)),this.turn=O(this.turn,new Uint16Array(
t)),this.kind=O(this.kind,new Uint32Array(t)),this.fill=O(this.fill,new Uint32Array(t)),this.flags=O(this.flags,new Uint8Array(t))}};function O(r,e){
return e.set(r),e}var bn=/([a-zA-Z])|(-?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)/g,vn={M:2,L:2,H:1,V:1,C:6,S:4,Q:4,T:2,Z:0},yn=1e3,wn=.04,Mn=.005,j=class{constructor(e,t,n){
this.closed=t;this.reach=n;this.paths=kn(e,t)}closed;reach;paths;flats=new Map;rings(e){let t=Math.max(0,Math.ceil(Math.log2(Math.max(e,1)))),
n=this.flats.get(t);return n||this.flats.set(t,n=this.paths.map(o=>xn(o,Math.min(Mn,wn/2**t)))),n}};function kn(r,e){let t=[...r.matchAll(bn)].
map(l=>l[1]??Number(l[2])/yn),n=[],o=null,[i,s]=[0,0],a=null,c="";for(let l=0;l<t.length;){typeof t[l]=="string"&&(c=t[l++]);let u=c.toUpperCase(),
m=vn[u];if(m===void 0)throw new Error(`path data with ${c||"no command"}`);let d=c!==u,p=t.slice(l,l+m);if(l+=m,u==="Z"){o&&([o.closed,[i,s]]=
[!0,o.from]),c=d?"m":"M",a=null;continue}if(d&&u!=="H"&&u!=="V")for(let y=0;y<m;y++)p[y]+=y%2?s:i;if(u==="M"||!o){o={from:[p[0],p[1]],pieces:[],
closed:e},n.push(o),[i,s]=o.from,c=d?"l":"L";continue}let f=(y,x)=>{o.pieces.push({to:[i=y,s=x]}),a=null},g=(y,x,L,E,K,S)=>{o.pieces.push({cubic:[
y,x,L,E,K,S]}),[i,s]=[K,S]},v=a?[2*i-a[0],2*s-a[1]]:[i,s];if(u==="L")f(p[0],p[1]);else if(u==="H")f(d?i+p[0]:p[0],s);else if(u==="V")f(i,d?s+
p[0]:p[0]);else if(u==="C")g(p[0],p[1],p[2],p[3],p[4],p[5]),a=[p[2],p[3]];else if(u==="S")g(v[0],v[1],p[0],p[1],p[2],p[3]),a=[p[0],p[1]];else{
let[y,x]=u==="Q"?[p[0],p[1]]:v,[L,E]=u==="Q"?[p[2],p[3]]:[p[0],p[1]];g(i+2/3*(y-i),s+2/3*(x-s),L+2/3*(y-L),E+2/3*(x-E),L,E),a=[y,x]}}return n}
function xn(r,e){let t=[...r.from];for(let n of r.pieces){if("to"in n){t.push(...n.to);continue}let[o,i]=[t[t.length-2],t[t.length-1]],[s,a,
c,l,u,m]=n.cubic,d=Math.max(Math.hypot(o-2*s+c,i-2*a+l),Math.hypot(s-2*c+u,a-2*l+m)),p=Math.min(64,Math.max(1,Math.ceil(Math.sqrt(.75*d/e))));
for(let f=1;f<=p;f++){let g=f/p,v=1-g,[y,x,L,E]=[v*v*v,3*v*v*g,3*v*g*g,g*g*g];t.push(y*o+x*s+L*c+E*u,y*i+x*a+L*l+E*m)}}return{xy:Float64Array.
from(t),closed:r.closed}}var En=["tone","importance"],Ln=["cells","axes","flow"],Ie=class{constructor(e){this.buffer=e}buffer;at=0;words(e){return this.taken(new Uint32Array(
this.buffer,this.at,e))}whole(e){return this.taken(new Int32Array(this.buffer,this.at,e))}shorts(e){return this.taken(new Uint16Array(this.buffer,
this.at,e))}bytes(e){return this.taken(new Uint8Array(this.buffer,this.at,e))}floats(e){return this.taken(new Float32Array(this.buffer,this.
at,e))}taken(e){return this.at+=Math.ceil(e.byteLength/4)*4,e}};function Tn(r){let[e,t,n]=r.words(4),o={layer:e,gone:n===0,ids:r.words(t)};return n&
1&&(o.x=r.whole(t),o.y=r.whole(t)),n&2&&(o.scale=r.words(t)),n&4&&(o.turn=r.shorts(t)),n&8&&(o.kind=r.words(t)),n&16&&(o.fill=r.words(t)),n&
32&&(o.flags=r.bytes(t)),o}function Sn(r){let[e,t,n,o,i,s,a]=r.words(8),c=r.bytes(o*i);return{map:En[e],top:t,left:n,height:o,width:i,rows:s,
columns:a,values:c}}function An(r){let[e,t,n,o]=r.words(4);return{what:Ln[e],closed:o!==0,start:r.words(t+1),xy:r.floats(2*n)}}function ae(r){
let e=new Ie(r),[t,n,o]=e.words(4),i=s=>Array.from({length:o},()=>s(e));if(t===1)return{revision:n,type:"items",chunks:i(Tn)};if(t===2)return{
revision:n,type:"raster",patches:i(Sn)};if(t===3)return{revision:n,type:"lines",lines:An(e)};throw new Error(`the server sent a frame of unk\
nown type ${t}`)}var le=class{constructor(e,t){this.painter=t;e.said.on(n=>{n.say==="hello"&&n.protocol!==1?e.lost.say(`This page speaks protocol ${1}, the s\
erver ${n.protocol}: load the page again.`):n.say==="hello"&&this.begin(n),n.say==="state"&&this.take(n),n.say==="saved"&&(this.saved.value=
n),n.say==="tabs"&&(this.tabs.value=n.count),n.say==="step"&&this.steps.say(n)}),e.frames.on(n=>{try{this.receive(n)}catch(o){e.lost.say(`A \
part of the drawing could not be read (${o.message}); it is asked for again.`),e.ask({do:"refresh"}).catch(()=>{})}}),this.changed.on(()=>this.
around=null)}painter;hello=new T(null);state=new T(null);saved=new T(null);tabs=new T(1);steps=new P;lines=new P;changed=new P;items=new G;kinds=new Map;canvas=[];around=null;missing=0;begun(e){
let t=!1;this.hello.on(n=>{n&&!t&&e(n),t||=n!==null})}selection(){return(this.around??=this.found()).box}found(){let{items:e}=this,t={left:1/0,
top:1/0,right:-1/0,bottom:-1/0};for(let n of this.selected()){let[o,i,s]=[e.x[n]/1e3,e.y[n]/1e3,this.reach(n)];t.left=Math.min(t.left,o-s),t.
top=Math.min(t.top,i-s),t.right=Math.max(t.right,o+s),t.bottom=Math.max(t.bottom,i+s)}return{box:t.left<t.right?t:null}}*selected(){if(!this.
state.value?.selected)return;let{items:e}=this;for(let t=0;t<e.end;t++)e.layer[t]&&e.flags[t]&1&&(yield t)}reach(e){return(this.kinds.get(this.
items.kind[e])?.reach??1)*this.items.scale[e]/1e3}begin(e){this.missing=1,this.painter({do:"begin",size:e.size,art:e.art}),this.hello.value=
e}take(e){e.reset&&(this.items.clear(),this.kinds.clear()),e.canvas&&(this.canvas=e.canvas);for(let s of e.kinds)this.kinds.set(s.id,new j(s.
d,s.closed,s.reach));let{revision:t,frames:n,layers:o,kinds:i}=e;this.painter({do:"state",revision:t,frames:n,reset:e.reset??!1,layers:o,kinds:i}),
this.missing=e.frames,this.state.value=e,this.missing||this.changed.say()}receive(e){let t=ae(e);if(t.type==="items")for(let n of t.chunks)this.
items.take(n);this.painter({do:"frame",buffer:e},[e]),t.type==="lines"?this.lines.say(t.lines.what):--this.missing===0&&this.changed.say()}};function et(r){let e=h("ol",{class:"history","aria-label":"Changes, the latest first"}),t="";return r.drawing.state.on(n=>{if(!n)return;let o=JSON.
stringify([n.undo,n.redo]);if(o===t)return;t=o;let i=(l,u)=>{r.ask({do:l,count:u})},s=n.redo.map((l,u)=>h("li",{class:"undone"},M(l,()=>i("r\
edo",u+1),{title:"Do again up to here"}))),a=n.undo.map((l,u)=>h("li",{},M(l,()=>u&&i("undo",u),{"aria-current":u===0?"step":null,title:u?"U\
ndo what came after":"The latest"}))),c=h("li",{},M(n.undo.length<50?"As it was opened":"Further back",()=>n.undo.length&&i("undo",n.undo.length),
{"aria-current":n.undo.length?null:"step"}));e.replaceChildren(...s.reverse(),...a,c)}),h("div",{class:"panel"},h("h2",{},"History"),e)}var tt=[["Black",[0,0,0,1]],["Cyan",[1,0,0,0]],["Magenta",[0,1,0,0]],["Yellow",[0,0,1,0]],["Sepia",[.3,.55,.75,.45]],["Red chalk",[.1,.8,.8,
.1]],["Blue ink",[1,.7,0,.3]]];var Pn=new Set(["size","strength","falloff"]),Dn=new Set(["path","on","layer"]),Z=class r{changed=new P;own=new Map;static shown(e){return e.
knobs.filter(t=>!Dn.has(t.name))}get(e,t){let n=this.own.get(this.key(e,t));return n===void 0?e.knobs.find(o=>o.name===t)?.default??null:n}set(e,t,n){
this.own.set(this.key(e,t),n),this.changed.say(t)}scale(e,t,n){let o=e.knobs.find(a=>a.name===t),i=this.get(e,t);if(!o||typeof i!="number")return;
let s=Number((i*n).toPrecision(2));this.set(e,t,Math.min(o.high??s,Math.max(Math.max(o.low??s,.01),s)))}params(e){let t={};for(let n of r.shown(
e)){let o=this.get(e,n.name);o!==null&&JSON.stringify(o)!==JSON.stringify(n.default)&&(t[n.name]=o)}return t}key(e,t){return Pn.has(t)&&e.knobs.
some(n=>n.name==="path")&&e.group!=="relax"?t:`${e.name} ${t}`}};function N(r,e,t){let o=Z.shown(e).filter(s=>!t||t.includes(s.name)).map(s=>{let a=r.settings.get(e,s.name);return{name:s.name,...oe(s,a,c=>r.
settings.set(e,s.name,c),r.libraries)}}),i=h("div",{class:"knobs"},...o.map(s=>s.element));return r.settings.changed.on(s=>{if(i.isConnected)
for(let a of o)a.name===s&&!a.element.contains(document.activeElement)&&a.show(r.settings.get(e,s))}),i}function Y(r,e,t=$(e.name),n=()=>({})){
let o=()=>{r.apply(e.name,{...r.settings.params(e),...n()})};return h("div",{class:"stack"},h("p",{class:"help"},e.help),N(r,e),M(t,o,{class:"\
wide"}))}function nt(r){let e=h("p",{class:"count"}),t=h("section",{class:"section stack","aria-label":"Paper"},h("h2",{},"Paper"),e);return r.drawing.
hello.on(n=>{if(!n)return;let[o,i]=n.size.map(s=>Number(s.toFixed(2)));e.textContent=`${o} × ${i} mm${n.margin===null?"":`, margin ${Number(
n.margin.toFixed(2))} mm`}`}),r.drawing.begun(()=>{let n=r.operation("paper");n&&t.append(h("details",{},h("summary",{},"Another paper"),Y(r,
n,"Put it on this paper")))}),t}function rt(r){let e=h("ul",{class:"layers","aria-label":"Layers, the topmost first"}),t=h("section",{class:"section stack","aria-label":"Th\
e layer worked on"}),n=h("input",{type:"radio",name:"layer",id:k("layer"),checked:!0,change:()=>r.layer.value=null}),o=U(D.add,"Add a layer",
()=>{r.apply("layer add",{})}),i="",s=()=>t.contains(document.activeElement)&&document.activeElement instanceof HTMLInputElement,a=()=>{let l=r.
drawing.state.value;if(!l)return;r.layer.value!==null&&!l.layers.some(p=>p.id===r.layer.value)&&(r.layer.value=null);let u=JSON.stringify([l.
layers,r.layer.value,l.selected>0]);if(u===i)return;i=u;let m=document.activeElement instanceof HTMLElement?document.activeElement.dataset.focus:
void 0;n.checked=r.layer.value===null,e.replaceChildren(...l.layers.map((p,f)=>Cn(r,p,f,l.layers.length)).reverse());let d=l.layers.find(p=>p.
id===r.layer.value);s()?i="":In(t,d?On(r,d,l.selected):[]),m&&e.querySelector(`[data-focus="${m}"]`)?.focus()};t.addEventListener("focusout",
()=>setTimeout(()=>t.matches(":active")||a())),r.drawing.state.on(a),r.layer.on(a);let c=h("div",{class:"layer layer-all"},n,h("label",{for:n.
id},"Work on all layers"),o);return h("div",{class:"panel"},h("h2",{},"Layers"),c,e,t,nt(r))}function In(r,e){let t=()=>[...r.querySelectorAll(
"input, select, button")],n=t().indexOf(document.activeElement);r.replaceChildren(...e),t()[n]?.focus()}function J(r,e,t){r.apply("layer edi\
t",{layer:e.id,...t})}function Cn(r,e,t,n){let o=k("layer"),i=u=>({"data-focus":`${e.id} ${u}`}),s=h("input",{type:"radio",name:"layer",id:o,
checked:r.layer.value===e.id,change:()=>r.layer.value=e.id,...i("radio")}),a=h("span",{class:"swatch"});a.style.background=`rgb(${e.rgb.join(
" ")})`;let c=(u,m,d)=>{let p=`${u==="hidden"?"Hide":"Lock"} ${e.name}`,f=()=>J(r,e,{[u]:!e[u]});return U(D[e[u]?m:d],p,f,{"aria-pressed":String(
e[u]),...i(u)})},l=(u,m,d)=>U(D[m],`${u} ${e.name}`,()=>{r.apply("layer order",{layer:e.id,to:d})},{disabled:d<0||d>=n,...i(m)});return h("l\
i",{class:e.hidden?"layer layer-hidden":"layer"},s,a,h("label",{for:o},e.name||`Layer ${e.id}`,h("small",{},e.items.toLocaleString("en"))),l(
"Raise","up",t+1),l("Lower","down",t-1),c("locked","locked","open"),c("hidden","hidden","shown"))}function On(r,e,t){let n=ce("Name",h("inpu\
t",{type:"text",value:e.name,change:s=>J(r,e,{name:ue(s)})})),o=M("Bring the selection here",()=>{r.apply("layer take",{layer:e.id})},{class:"\
wide",disabled:!t}),i=M("Select all of it",()=>{r.apply("select",{by:"layer",layer:e.id})},{class:"wide"});return[h("h3",{},e.name||`Layer ${e.
id}`),n,...e.kind==="still"?[]:[...Hn(r,e),o,i],M("Remove the layer",()=>{r.apply("layer remove",{layer:e.id})},{class:"wide"})]}function Hn(r,e){
let t=()=>r.drawing.state.value?.layers.find(l=>l.id===e.id)??e,n=l=>J(r,e,{cmyk:l,...t().spot?{spot:t().ink}:{}}),o=h("input",{type:"number",
min:0,max:50,step:"any",value:e.pen??0,change:l=>J(r,e,{pen:Number(ue(l))})}),i=h("select",{change:()=>i.value==="spot"?s.hidden=!1:J(r,e,{spot:""})},
h("option",{value:"process",selected:!e.spot},"process"),h("option",{value:"spot",selected:e.spot},"spot")),s=ce("Spot name",h("input",{type:"\
text",value:e.spot?e.ink:"",placeholder:"as in the swatch book",spellcheck:"false",change:l=>J(r,e,{spot:ue(l)})}));s.hidden=!e.spot;let a=e.
cmyk.map((l,u)=>h("input",{type:"number",min:0,max:100,step:1,value:Math.round(l*100),"aria-label":`${["Cyan","Magenta","Yellow","Black"][u]}\
, per cent`,change:m=>n(t().cmyk.map((d,p)=>p===u?Number(ue(m))/100:d))})),c=tt.map(([l,u])=>M(l,()=>n(u)));return[ce("Pen",o,h("span",{class:"\
unit"},"mm; 0 fills")),ce("Ink",i),s,h("div",{class:"knob"},h("span",{},e.spot?"Looks like":"C M Y K"),h("div",{class:"knob-inputs cmyk"},...a)),
h("div",{class:"row chips"},...c)]}function ce(r,e,...t){return e.id=k("field"),h("div",{class:"knob"},h("label",{for:e.id},r),h("div",{class:"\
knob-inputs"},e,...t))}function ue(r){return r.target.value}var ot=[200,500,1e3,2e3,4e3],Rn=1001,Kn=1009,he=class{constructor(e){this.wire=e}wire;line=new T("connecting");said=new P;frames=new P;lost=new P;socket=null;number=0;tries=0;waiting=new Map;connect(){
let e=this.wire.open();this.socket=e,e.addEventListener("open",()=>{this.tries=0,this.line.value="open"}),e.addEventListener("message",t=>{let{
data:n}=t;typeof n=="string"?this.hear(JSON.parse(n)):this.frames.say(n)}),e.addEventListener("close",t=>this.closed(t.code))}ask(e){if(this.
socket?.readyState!==WebSocket.OPEN)return Promise.reject(new Error("There is no connection to the server."));let t=++this.number;return this.
socket.send(JSON.stringify({...e,n:t})),new Promise((n,o)=>this.waiting.set(t,{done:n,failed:o}))}hear(e){(e.say==="done"||e.say==="error")&&
this.answered(e),e.say==="closed"&&(this.line.value="ended"),this.said.say(e)}answered(e){if(e.say==="error"&&e.n===null)return this.lost.say(
e.text);let t=this.waiting.get(e.n??0);this.waiting.delete(e.n??0),e.say==="done"?t?.done(e):t?.failed(new Error(e.text))}closed(e){this.socket=
null;let t=e===Kn?"That was more than the server takes at once.":"The connection broke before the server answered.";for(let{failed:n}of this.
waiting.values())n(new Error(t));this.waiting.clear(),e===Rn?this.line.value="ended":this.line.value!=="ended"&&(this.line.value="broken"),setTimeout(
()=>this.connect(),ot[Math.min(this.tries++,ot.length-1)])}};var it=6e3,me=class{list=w("messages");note(e){this.show(e,"note",it)}error(e){this.show(e,"error",2*it)}show(e,t,n){for(let i of[...this.list.
children])(i.textContent===e||this.list.children.length>3)&&i.remove();let o=h("p",{class:t},e);o.addEventListener("click",()=>o.remove()),this.
list.append(o),setTimeout(()=>o.remove(),n)}};function lt(r,e){let[t,n]=r.viewport.px(e.left,e.top),[o,i]=r.viewport.px(e.right,e.bottom);return{left:t-4,top:n-4,right:o+4,bottom:i+4,knob:[
(t+o)/2,n-4-22]}}function ct(r,e,t){let{left:n,top:o,right:i,bottom:s,knob:a}=lt(r,t);e.strokeRect(n,o,i-n,s-o),e.beginPath(),e.moveTo(a[0],
o),e.lineTo(a[0],a[1]+5),e.stroke(),e.beginPath(),e.arc(...a,5,0,2*Math.PI),e.save(),e.fillStyle="#fff",e.fill(),e.restore(),e.stroke()}function ut(r,e){
let t=r.drawing.selection();if(!t||!r.operation("move"))return null;let{left:n,top:o,right:i,bottom:s,knob:a}=lt(r,t),[c,l]=r.viewport.px(e.
x,e.y);return Math.hypot(c-a[0],l-a[1])<=10?st(r,e,t,!0):c>=n&&c<=i&&l>=o&&l<=s?st(r,e,t,!1):null}function st(r,e,t,n){let o=$n(r),[i,s,a]=[
0,0,0];return{move:c=>{let l=c[c.length-1];n?a=at(l.x-o[0],l.y-o[1])-at(e.x-o[0],e.y-o[1]):[i,s]=[l.x-e.x,l.y-e.y]},end:()=>{let c=u=>Math.round(
u*1e3)/1e3,l=n?{angle:c((a+540)%360-180)}:{dx:c(i),dy:c(s)};Object.values(l).some(u=>u!==0)?r.apply("move",l):n||r.apply("select",{by:"pick",
path:[e.x,e.y,1]})},cancel:()=>{},draw:c=>Nn(r,c,t,o,i,s,a*Math.PI/180)}}function $n(r){let{items:e}=r.drawing,[t,n,o,i]=[1/0,1/0,-1/0,-1/0];
for(let s of r.drawing.selected())[t,o]=[Math.min(t,e.x[s]),Math.max(o,e.x[s])],[n,i]=[Math.min(n,e.y[s]),Math.max(i,e.y[s])];return[(t+o)/2e3,
(n+i)/2e3]}function at(r,e){return Math.atan2(e,r)*180/Math.PI}function Nn(r,e,t,n,o,i,s){let{drawing:a,viewport:c}=r,{items:l}=a,u=c.scale/
c.ratio,m=(d,p)=>{let[f,g]=[d-n[0],p-n[1]];return c.px(n[0]+Math.cos(s)*f-Math.sin(s)*g+o,n[1]+Math.sin(s)*f+Math.cos(s)*g+i)};if(e.beginPath(),
a.state.value.selected>400){let{left:d,top:p,right:f,bottom:g}=t;for(let v of[[d,p],[f,p],[f,g],[d,g]])e.lineTo(...m(...v));return e.closePath(),
e.stroke()}for(let d of a.selected()){let p=a.kinds.get(l.kind[d]);if(!p)continue;let[f,g]=m(l.x[d]/1e3,l.y[d]/1e3),v=l.scale[d]/1e3*u,y=l.turn[d]/
65536*2*Math.PI+s,[x,L]=[v*Math.cos(y),v*Math.sin(y)];for(let{xy:E,closed:K}of p.rings(v)){for(let S=0;S<E.length;S+=2){let[C,I]=[f+x*E[S]-L*
E[S+1],g+L*E[S]+x*E[S+1]];S?e.lineTo(C,I):e.moveTo(C,I)}K&&e.closePath()}}e.stroke()}function mt(r){let e=10**Math.floor(Math.log10(r));return[1,2,5,10].map(t=>t*e).find(t=>t>=r*.999)}function dt(r,e,t){let[n,o]=[e.width/e.ratio,
e.height/e.ratio];r.fillStyle=t.ground,r.fillRect(0,0,n,18),r.fillRect(0,0,18,o),r.font="10px ui-sans-serif, system-ui, sans-serif",r.textBaseline=
"alphabetic",r.lineWidth=1,r.setLineDash([]),r.strokeStyle=t.stroke,ht(r,e,n,t,!1),r.save(),r.transform(0,1,1,0,0,0),ht(r,e,o,t,!0),r.restore(),
r.fillStyle=t.ground,r.fillRect(0,0,18,18),r.fillStyle=t.text,r.fillText("mm",2,12)}function ht(r,e,t,n,o){let i=e.scale/e.ratio,s=(o?e.y:e.
x)/e.ratio,a=mt(56/i),c=[10,5,2].map(u=>a/u).find(u=>u*i>=5&&Bn(u))??a,l=Math.round(a/c);r.beginPath();for(let u=Math.floor((18-s)/i/c);u*c*
i+s<t;u++){let m=Math.round(u*c*i+s)+.5,d=u%l===0;r.moveTo(m,18),r.lineTo(m,d?4:14),d&&Un(r,Number((u*c).toPrecision(9)),m,n,o)}r.stroke(),r.
beginPath(),r.moveTo(0,18-.5),r.lineTo(t,18-.5),r.stroke()}function Bn(r){return Math.abs(mt(r)-r)<1e-6*r}function Un(r,e,t,n,o){if(r.fillStyle=
n.text,!o)return r.fillText(String(e),t+3,11);r.save(),r.transform(0,1,1,0,0,0),r.translate(3,t+3),r.rotate(Math.PI/2),r.fillText(String(e),
0,0),r.restore()}var de=class{constructor(e){this.desk=e;let{drawing:t,viewport:n,appearance:o,tool:i,region:s,settings:a}=e,c=()=>this.ask();for(let l of[t.
changed,n.changed,o.changed])l.on(c);for(let l of[t.hello,i,s])l.on(c);a.changed.on(c)}desk;gesture=null;canvas=w("overlay");ring=w("ring");cross=w(
"cross");notches=[w("across"),w("down")];pointer=null;asked=!1;point(e,t=!1){this.pointer=e,this.cross.hidden=!(e&&t),e&&(this.cross.style.transform=
`translate(${e[0]}px, ${e[1]}px)`),this.follow()}ask(){this.asked||(this.asked=!0,requestAnimationFrame(()=>this.draw()))}follow(){let[e,t]=this.
notches;e.hidden=t.hidden=!(this.pointer&&this.desk.appearance.rulers.value),this.pointer&&(e.style.transform=`translateX(${this.pointer[0]}\
px)`),this.pointer&&(t.style.transform=`translateY(${this.pointer[1]}px)`);let{tool:n,settings:o,viewport:i}=this.desk,s=n.value,a=this.pointer&&
s?.ring&&s.operation;if(this.ring.hidden=!a,!a||!this.pointer)return;let c=Number(o.get(s.operation,"size")),l=Math.max(3,c*i.scale/i.ratio),
[u,m]=[this.pointer[0]-l/2,this.pointer[1]-l/2];this.ring.style.transform=`translate(${u}px, ${m}px)`,this.ring.style.width=this.ring.style.
height=`${l}px`}draw(){this.asked=!1,this.follow();let{canvas:e,desk:t}=this,{viewport:n,drawing:o,appearance:i}=t;(e.width!==n.width||e.height!==
n.height)&&([e.width,e.height]=[n.width,n.height]);let s=e.getContext("2d");if(s.setTransform(n.ratio,0,0,n.ratio,0,0),s.clearRect(0,0,e.width,
e.height),!o.hello.value)return;i.guides.value&&this.guides(s),this.outlines(s);let a={ground:i.colour("panel"),stroke:i.colour("ruler"),text:i.
colour("muted")};i.rulers.value&&dt(s,n,a)}outlines(e){let{drawing:t,appearance:n,region:o,tool:i}=this.desk,s=i.value?.part==="select"&&!this.
gesture?.draw?t.selection():null,a=n.colour("accent-on-paper");for(let c of[!0,!1]){let l=(u,m)=>{e.strokeStyle=c?"#fffd":u,e.lineWidth=c?4:
1.5,e.setLineDash(c?[]:m)};l(n.colour("wall"),[6,3]);for(let u of t.state.value?.wall??[])this.outline(e,u,2);l(a,[6,3]),o.value&&this.outline(
e,o.value,3),l(a,[]),s&&ct(this.desk,e,s),e.fillStyle=c?"transparent":`color-mix(in srgb, ${a} 12%, transparent)`,this.gesture?.draw?.(e)}}guides(e){
let{viewport:t,drawing:n,appearance:o}=this.desk,{size:i,margin:s}=n.hello.value,a=c=>{let[[l,u],[m,d]]=[t.px(c,c),t.px(i[0]-c,i[1]-c)];e.strokeRect(
Math.round(l)+.5,Math.round(u)+.5,Math.round(m-l)-1,Math.round(d-u)-1)};e.lineWidth=1,e.setLineDash([]),e.strokeStyle=o.colour("edge"),a(0),
e.setLineDash([2,3]),e.strokeStyle=o.colour("guide"),s&&a(s);for(let c of n.canvas)this.outline(e,c,2)}outline(e,t,n){e.beginPath();for(let o=0;o+
1<t.length;o+=n)e.lineTo(...this.desk.viewport.px(t[o],t[o+1]));e.closePath(),e.stroke()}};var pe=class{constructor(e,t,n,o,i){this.surface=e;this.viewport=t;this.begin=n;this.hover=o;this.drawn=i;e.addEventListener("pointerdown",s=>this.
down(s)),e.addEventListener("pointermove",s=>this.move(s)),e.addEventListener("pointerup",s=>this.up(s,!1)),e.addEventListener("pointercance\
l",s=>this.up(s,!0)),e.addEventListener("pointerleave",s=>this.hover(s.offsetX,s.offsetY,!1)),e.addEventListener("contextmenu",s=>s.preventDefault()),
e.addEventListener("wheel",s=>this.wheel(s),{passive:!1})}surface;viewport;begin;hover;drawn;gesture=null;owner=-1;panning=!1;waiting=null;fingers=new Map;space=!1;get busy(){
return this.gesture!==null}cancel(){this.drop(),this.finish(e=>e.cancel())}place(e){let t=this.surface.getBoundingClientRect();return{x:e.clientX-
t.left,y:e.clientY-t.top}}point(e){let{x:t,y:n}=this.place(e),[o,i]=this.viewport.mm(t,n);return{x:o,y:i,pressure:e.pointerType==="pen"?e.pressure:
1}}down(e){if(this.surface.focus({preventScroll:!0}),this.surface.setPointerCapture(e.pointerId),e.pointerType==="touch"&&(this.fingers.set(
e.pointerId,this.place(e)),this.fingers.size>1))return this.cancel();if(this.gesture||this.panning)return;if(e.button===1||this.space){this.
panning=!0,this.owner=e.pointerId,this.fingers.set(e.pointerId,this.place(e));return}if(e.button!==0)return;this.owner=e.pointerId;let[t,n]=[
this.point(e),{shift:e.shiftKey,alt:e.altKey}],o=()=>{this.drop(),this.gesture=this.begin(t,n),this.drawn(this.gesture)};e.pointerType==="to\
uch"?this.waiting={start:o,timer:setTimeout(o,80),...this.place(e)}:o()}drop(){clearTimeout(this.waiting?.timer),this.waiting=null}move(e){let{
x:t,y:n}=this.place(e);this.hover(t,n,e.pointerType!=="touch"||this.gesture!==null);let o=this.fingers.get(e.pointerId);if(o&&(this.fingers.
size>1||this.panning))return this.pinch(e.pointerId,o,{x:t,y:n});if(o&&this.fingers.set(e.pointerId,{x:t,y:n}),this.waiting&&Math.hypot(t-this.
waiting.x,n-this.waiting.y)>5&&this.waiting.start(),!this.gesture||e.pointerId!==this.owner)return;let i=e.getCoalescedEvents?.()??[];this.gesture.
move((i.length?i:[e]).map(s=>this.point(s))),this.drawn(this.gesture)}pinch(e,t,n){let o=[...this.fingers].find(([a])=>a!==e)?.[1];if(this.fingers.
set(e,n),!o)return this.viewport.pan(n.x-t.x,n.y-t.y);let[i,s]=[Math.hypot(t.x-o.x,t.y-o.y),Math.hypot(n.x-o.x,n.y-o.y)];this.viewport.pan((n.
x-t.x)/2,(n.y-t.y)/2),i>10&&s>10&&this.viewport.zoom(s/i,(n.x+o.x)/2,(n.y+o.y)/2)}up(e,t){this.fingers.delete(e.pointerId),e.pointerId===this.
owner&&(this.panning=!1,t||this.waiting?.start(),this.finish(n=>t?n.cancel():n.end()))}finish(e){let{gesture:t}=this;this.gesture=null,t&&e(
t),this.drawn(null)}wheel(e){e.preventDefault();let t=e.deltaMode===1?16:e.deltaMode===2?400:1,[n,o]=[e.deltaX*t,e.deltaY*t],{x:i,y:s}=this.
place(e);e.ctrlKey||e.metaKey?this.viewport.zoom(Math.exp(-Math.max(-60,Math.min(60,o))*.006),i,s):e.shiftKey&&!n?this.viewport.pan(-o,0):this.
viewport.pan(-n,-o)}};var zn={ArrowLeft:[-1,0],ArrowRight:[1,0],ArrowUp:[0,-1],ArrowDown:[0,1]};function pt(r,e,t){let{viewport:n}=r,o=w("surface"),i=null,s=(l,u,m)=>{
i=null,e.point(m?[l,u]:null),t.point(m?n.mm(l,u):null)},a=(l,u)=>r.link.line.value==="open"?r.tool.value?.begin(l,u)??null:null,c=new pe(o,n,
a,s,l=>{e.gesture=l,e.ask()});return o.addEventListener("keydown",l=>{let u=zn[l.key];if(l.ctrlKey||l.metaKey||!u&&l.key!=="Enter")return;l.
preventDefault();let m=l.shiftKey?10:1;i??=n.mm(n.width/n.ratio/2,n.height/n.ratio/2),u?i=[i[0]+m*u[0],i[1]+m*u[1]]:a({x:i[0],y:i[1],pressure:1},
{shift:l.shiftKey,alt:l.altKey})?.end(),e.point(n.px(...i),!0),t.point(i)}),o.addEventListener("blur",()=>i&&s(0,0,!1)),Wn(o,c),r.tool.on(l=>o.
dataset.part=l?.part??""),c}function Wn(r,e){let t=n=>{e.space=n,r.classList.toggle("panning",n)};window.addEventListener("keydown",n=>{n.key!==
" "||n.target!==r&&n.target!==document.body||(n.preventDefault(),t(!0))}),window.addEventListener("keyup",n=>{n.key===" "&&t(!1)}),window.addEventListener(
"blur",()=>t(!1))}var Vn="insert";function ft(r){let e=w("rail"),t=new Map;r.tools.on(n=>{t=new Map(n.map(s=>[s.name,Fn(r,s)]));let i=["look","select","brush",
"outline"].map(s=>h("div",{class:"rail-part"},...n.filter(a=>a.part===s).map(a=>t.get(a.name))));e.replaceChildren(...i.filter(s=>s.children.
length)),r.tool.value=n.find(s=>s.name===(r.tool.value?.name??Vn))??n[0]??null}),r.tool.on(n=>{for(let[o,i]of t)i.setAttribute("aria-pressed",
String(o===n?.name)),i.tabIndex=o===n?.name?0:-1}),e.addEventListener("keydown",n=>Oe(n,[...t.values()]))}function Fn(r,e){let t=`${e.title}${e.
key?` (${e.key.toUpperCase()})`:""}: ${e.help}`,n=e.key?{"aria-keyshortcuts":e.key}:{},o=U(D[e.name]??D.insert,e.title,()=>r.tool.value=e,{"\
data-tool":e.name,...n});return o.title=t,o}function Oe(r,e){let t=e.indexOf(document.activeElement),n={ArrowDown:t+1,ArrowRight:t+1,ArrowUp:t-
1,ArrowLeft:t-1,Home:0,End:e.length-1}[r.key];t<0||n===void 0||(r.preventDefault(),r.stopPropagation(),e[(n+e.length)%e.length].focus())}var gt=256,He=56,fe=4,ge=class{constructor(e){this.name=e;let t=document.createElementNS("http://www.w3.org/2000/svg","svg");t.setAttribute(
"viewBox",`0 0 ${gt} ${He}`),t.setAttribute("aria-hidden","true"),t.append(this.line),this.element=h("figure",{class:"plot"},h("figcaption",
{},h("span",{},e),this.now),t)}name;element;line=document.createElementNS("http://www.w3.org/2000/svg","polyline");now=h("span",{class:"plot\
-now"});values=[];clear(){this.values.length=0,this.draw()}add(e,t){Number.isFinite(t)&&(this.values.push([e,t]),this.values.length>2e3&&this.
values.splice(0,this.values.length,...this.values.filter((n,o)=>o%2)),this.draw())}draw(){let{values:e}=this,[t,n]=[e[0]?.[0]??0,e[e.length-
1]?.[0]??1],o=Math.min(...e.map(([,c])=>c)),i=Math.max(...e.map(([,c])=>c)),s=c=>fe+(c-t)/Math.max(n-t,1)*(gt-2*fe),a=c=>He-fe-(c-o)/(i-o||1)*
(He-2*fe);this.line.setAttribute("points",e.map(([c,l])=>`${s(c).toFixed(1)},${a(l).toFixed(1)}`).join(" ")),this.now.textContent=e.length?Number(
e[e.length-1][1].toPrecision(4)).toString():""}};var Gn=["energy","movement","turning"];function bt(r){let e=h("div",{class:"panel"});return r.drawing.begun(t=>{let n=r.operation("relax"),o=t.
operations.filter(i=>i.group==="relax"&&i!==n);e.replaceChildren(...n?Zn(r,n):[],...o.map(i=>jn(r,i)))}),e}function jn(r,e){let t=()=>{let o=e.
knobs.some(i=>i.name==="path")?r.region.value:null;return o?{path:o}:{}},n=Y(r,e,void 0,()=>({...t(),...r.ofLayer(e)}));return h("details",{
class:"section"},h("summary",{},e.name==="tile"?"Lay tiles":e.name==="cut"?"Cut stones":e.name),n)}function Zn(r,e){let t=h("select",{id:k("\
on")},...["all","selection"].map(p=>h("option",{value:p},p))),n=h("input",{type:"number",id:k("steps"),min:1,max:1e4,step:1,value:10}),o=Gn.
map(p=>new ge(p)),i=h("p",{class:"count",role:"status"}),s=p=>{if(p>1||!p)for(let g of o)g.clear();let f={...r.settings.params(e),...r.ofLayer(
e),on:t.value};r.apply(e.name,f,{times:p}).then(g=>{g&&(i.textContent=g.stopped?"Stopped":"")})},a=()=>{n.reportValidity()&&s(n.valueAsNumber)},
c=Re("Play","play",()=>{let{busy:p}=r.drawing.state.value??{};p?r.ask({do:p.paused?"resume":"pause"}):s(0)}),l=Re("Stop","stop",()=>{r.ask({
do:"stop"})}),u=Re("Undo it","cancel",()=>{r.ask({do:"cancel"})}),m=M("1 step",()=>s(1)),d=M("steps",a);return r.drawing.steps.on(p=>{if(p.stage!==
"recover"){i.textContent=`${p.stage} ${p.done}${p.total?` of ${p.total}`:""}`;for(let f of o){let g=p.facts[f.name];g!==void 0&&f.add(p.done,
g),f.element.hidden=g===void 0&&f.name==="turning"}}}),r.drawing.state.on(p=>{let f=p?.busy??null,g=f!==null&&!f.paused;R(c,{"aria-label":g?
"Pause":f?"Go on":"Play"}),c.replaceChildren(V(g?D.pause:D.play),g?"Pause":f?"Go on":"Play"),l.disabled=u.disabled=!f,m.disabled=d.disabled=
f!==null;for(let v of t.options)v.value==="selection"&&(v.disabled=!p?.selected);p?.selected||(t.value="all")}),[h("h2",{},"Relaxation"),h("\
p",{class:"help"},e.help),N(r,e,["variant"]),h("div",{class:"knob"},h("label",{for:t.id},"On"),h("div",{class:"knob-inputs"},t)),h("div",{class:"\
row"},c,l,u),h("div",{class:"row"},m,h("span",{class:"joined"},h("label",{for:n.id,class:"unseen"},"Number of steps"),n,d)),i,...o.map(p=>p.
element),h("details",{},h("summary",{},"Finer settings"),N(r,e,Yn(e)))]}function Yn(r){return r.knobs.map(e=>e.name).filter(e=>!["variant","\
size","strength","falloff"].includes(e))}function Re(r,e,t){return h("button",{type:"button",click:t,"aria-label":r},V(D[e]),r)}async function vt(r){let e=await r.get("picture.png");return e&&createImageBitmap(e)}async function yt(r,e,t){let n=await r.get(`still-${e}.\
svg`);if(!n)return null;let o=new Image;o.src=URL.createObjectURL(n),await o.decode(),URL.revokeObjectURL(o.src);let i=2e3/Math.max(...t),s=new OffscreenCanvas(
Math.ceil(t[0]*i),Math.ceil(t[1]*i));return s.getContext("2d").drawImage(o,0,0,s.width,s.height),s.transferToImageBitmap()}function wt(r,e){let{viewport:t,appearance:n,drawing:o}=r,i=w("stage"),s=w("drawing").transferControlToOffscreen();e({do:"canvas",canvas:s},
[s]);let a=!1;t.changed.on(()=>{a||(a=!0,requestAnimationFrame(()=>{a=!1,e({do:"view",view:t.view,width:t.width,height:t.height})}))});let c=()=>{
let[m,d]=[i.clientWidth,i.clientHeight].map(p=>Math.round(p*devicePixelRatio));t.resize(m,d,devicePixelRatio)};new ResizeObserver(c).observe(
i),c();let l=()=>e({do:"look",look:n.look});n.changed.on(l),l();let u="";o.hello.on(m=>{if(!m)return;let d=JSON.stringify([m.name,m.size]);d!==
u&&t.show(m.size),u=d}),Jn(r,e)}function Jn(r,e){let{drawing:t}=r,{wire:n}=r.link,o=(s,a)=>e({do:"image",name:s,bitmap:a},a?[a]:[]),i=new Set;
t.hello.on(s=>{i.clear(),s&&(s.picture?vt(n).then(a=>o("picture",a)):o("picture",null))}),t.state.on(s=>{let{size:a}=t.hello.value??{};for(let{
id:c,kind:l}of s?.layers??[])l!=="still"||i.has(c)||!a||(i.add(c),yt(n,c,a).then(u=>o(c,u)))})}var Mt={connecting:"",open:"",broken:"The connection broke. Nothing is lost; connecting again…",ended:"The server has ended. All is saved:\
 start crowquill edit again and open the address that it prints."},be=class{constructor(e){this.desk=e;let{drawing:t,viewport:n,link:o}=e;n.
changed.on(()=>this.scale()),t.changed.on(()=>{let{marks:s=0,selected:a=0}=t.state.value??{};w("count").textContent=`${s.toLocaleString("en")}\
 marks${a?`, ${a.toLocaleString("en")} selected`:""}`}),t.hello.on(s=>{s&&(w("name").textContent=s.name,document.title=`${s.name} · crowquil\
l`)});let i=w("saved");t.saved.on(s=>{i.textContent=!s||s.ok?"Every change is saved":s.text||`${s.waiting} changes are not saved yet`,R(i,{"\
data-ok":String(s?.ok??!0),role:s?.ok===!1?"alert":"status"})}),t.tabs.on(s=>{w("tab-count").textContent=s>1?`Open in ${s} tabs`:""}),o.line.
on(s=>{this.banner(Mt[s]),R(w("app"),{"data-line":s})}),t.steps.on(s=>{s.stage==="recover"&&this.banner(`Doing again what was done: ${s.done}\
 of ${s.total} changes`)}),t.state.on(s=>s&&this.banner(Mt[o.line.value]))}desk;zoom=w("zoom");place=w("place");point(e){let t=this.desk.viewport.
scale,n=Math.max(1,Math.min(3,Math.ceil(Math.log10(t))));this.place.textContent=e?`${e[0].toFixed(n)}, ${e[1].toFixed(n)} mm`:""}banner(e){let t=w(
"banner");t.textContent!==e&&(t.textContent=e),t.hidden=!e}scale(){let{scale:e,ratio:t}=this.desk.viewport,n=e/t*25.4*100/96;this.zoom.textContent=
`${n<10?n.toPrecision(2):Math.round(n).toLocaleString("en")} %`}};function xt(r){let e=h("div",{class:"panel"});return r.drawing.begun(t=>{let n=t.operations.filter(o=>o.group==="style");n.length&&e.replaceChildren(
...qn(r,n))}),e}function kt(r){return r.name.replace(/^redraw /,"")}function qn(r,e){let t=h("select",{id:k("style")},...e.map(d=>h("option",
{value:d.name},kt(d)))),n=h("div",{}),o=new Map,i=()=>e.find(d=>d.name===t.value),s=()=>{let d=i();o.has(d.name)||o.set(d.name,h("div",{class:"\
stack"},h("p",{class:"help"},d.help),N(r,d))),n.replaceChildren(o.get(d.name))},a=h("p",{class:"help"}),c=d=>{let p=i();r.messages.note(`${$(
kt(p))} is being drawn; Stop ends it.`),r.apply(p.name,{...r.settings.params(p),...d?{path:d}:{}})},l=M("Draw the region anew",()=>c(r.region.
value),{class:"wide primary"}),u=M("Draw all anew",()=>c(null),{class:"wide"}),m=M("Stop",()=>{r.ask({do:"cancel"})},{class:"wide"});return r.
region.on(d=>{l.disabled=!d,a.textContent=d?"The region is outlined on the canvas.":"To draw a part alone, outline it with the region tool (\
D)."}),r.drawing.state.on(d=>m.disabled=!d?.busy?.op.startsWith("redraw")),t.addEventListener("change",s),s(),[h("h2",{},"Style"),h("div",{class:"\
knob"},h("label",{for:t.id},"Style"),h("div",{class:"knob-inputs"},t)),n,a,l,u,m]}function Et(r){let[e,t]=[w("tabs"),w("panels")],n=r.map(({name:i,panel:s})=>{let[a,c]=[k("tab"),k("panel")];for(let[l,u]of Object.entries({id:c,
role:"tabpanel","aria-labelledby":a}))s.setAttribute(l,u);return h("button",{type:"button",role:"tab",id:a,"aria-controls":c,click:()=>o(i)},
i)}),o=i=>{r.forEach((s,a)=>{let c=s.name===i;s.panel.hidden=!c,n[a].setAttribute("aria-selected",String(c)),n[a].tabIndex=c?0:-1})};return e.
addEventListener("keydown",i=>{Oe(i,n),document.activeElement!==i.target&&document.activeElement.click()}),e.replaceChildren(...n),t.replaceChildren(
...r.map(i=>i.panel)),o(r[0].name),o}function Lt(r){let e=h("div",{}),t=h("section",{class:"section stack","aria-label":"Selection"}),n=new Map;return r.tool.on(o=>{o&&(n.has(o)||
n.set(o,Xn(r,o)),e.replaceChildren(n.get(o)))}),r.drawing.begun(()=>t.replaceChildren(...Qn(r))),h("div",{class:"panel"},e,t)}function Xn(r,e){
let{operation:t,part:n,name:o}=e;return h("div",{class:"stack"},h("h2",{},e.title),h("p",{class:"help"},e.help),t&&e.ring&&N(r,t,n==="select"?
["size"]:void 0),t&&n==="brush"&&_n(r,t),o==="wall"&&M("Take the wall away",()=>{r.apply("wall",{})},{class:"wide"}),o==="region"&&M("Forget\
 the region",()=>r.region.value=null,{class:"wide"}))}function _n(r,e){if(!e.knobs.some(o=>o.name==="on"))return null;let t=o=>()=>{r.apply(
e.name,{...r.settings.params(e),...r.ofLayer(e),on:o})},n=M("On the selection",t("selection"));return r.drawing.changed.on(()=>n.disabled=!r.
drawing.state.value?.selected),n.disabled=!r.drawing.state.value?.selected,h("div",{class:"row"},n,M("On all",t("all")))}function Qn(r){let e=r.
operation("select");if(!e)return[];let t=h("p",{class:"count"}),n=[],o=(c,l,u)=>{if(!r.operation(l))return null;let m=M(c,()=>{r.apply(l,u)});
return n.push(m),m},i=(c,l)=>M(c,()=>{r.apply("select",{...l,...r.ofLayer(e)})}),s=h("details",{},h("summary",{},"By the tone beneath"),N(r,
e,["low","high"]),M("Select",()=>er(r,e),{class:"wide"})),a=[h("h2",{},"Selection"),t,h("div",{class:"row"},i("All",{by:"all"}),i("None",{by:"\
none"}),i("Invert",{by:"invert"})),s,h("div",{class:"row"},o("Erase","erase",{on:"selection"}),o("Duplicate","duplicate",{})),h("div",{class:"\
row"},o("Freeze","freeze",{on:"selection"}),o("Thaw","freeze",{on:"selection",frozen:!1})),h("div",{class:"row"},o("Align to the flow","turn",
{on:"selection",by:"flow"})),tr(r)];return r.drawing.changed.on(()=>{let{selected:c=0,marks:l=0}=r.drawing.state.value??{};t.textContent=`${c.
toLocaleString("en")} of ${l.toLocaleString("en")} selected`;for(let u of n)u.disabled=!c}),a.filter(c=>c!==null)}function er(r,e){let{low:t,
high:n}={low:r.settings.get(e,"low"),high:r.settings.get(e,"high")};r.apply("select",{by:"tone",low:t,high:n,...r.ofLayer(e)})}function tr(r){
let e=r.operation("move");return e?h("details",{},h("summary",{},"Move and turn by numbers"),Y(r,e,"Move")):null}var Ke=class{constructor(e,t){this.apart=t;this.last=e,this.left=t}apart;last;left;to(e){let t=[],{last:n}=this,o=Math.hypot(e.x-n.x,e.y-n.y),
i=this.left;for(;i<=o;i+=this.apart)t.push(nr(n,e,i/o));return this.left=i-o,this.last=e,t}};function nr(r,e,t){let n=(o,i)=>o+t*(i-o);return{
x:n(r.x,e.x),y:n(r.y,e.y),pressure:n(r.pressure,e.pressure)}}function $e(r,e){let t=new Ke(r,Math.max(e.size*.12,.02)),n=[r],o=null,i=r,s=0,
a=!1,c=!1,l=()=>n.length>=(a?1:e.least)&&(!e.lead||o!==null||n.length>1),u=()=>{for(;!c&&s<2&&l();){let f=n.splice(0,Math.floor(e.most/3)-1),
g=e.lead&&o?[o,...f]:f;o=f[f.length-1],s++;let v=g.flatMap(y=>[Tt(y.x),Tt(y.y),Math.round(y.pressure*1e3)/1e3]);e.send(v).then(m,()=>c=!0)}},
m=()=>{s--,u()},d=e.lingers?setInterval(()=>{s||n.length||(n.push(i),u())},70):void 0,p=()=>{a=!0,clearInterval(d),u()};return u(),{move(f){
for(let g of f)n.push(...t.to(i=g));u()},end(){i!==(n[n.length-1]??o)&&n.push(i),p()},cancel(){n=[],p()}}}function Tt(r){return Math.round(r*
1e3)/1e3}var St={insert:"b",erase:"e",push:"p",attract:"a",jitter:"j",resize:"s",turn:"t",swap:"g",freeze:"f",paint:"i",relax:"r"},rr=new Set(["inser\
t","attract","jitter","relax","paint"]);function At(r,e){let t=e.filter(s=>Ne(s,"path")&&Ne(s,"size")&&s.group!=="select"&&s.group!=="style"),
n=Object.keys(St),o=s=>n.includes(s.name)?n.indexOf(s.name):n.length;t.sort((s,a)=>o(s)-o(a));let i=e.find(s=>s.name==="select");return[...or(
r),...i?ir(r,i):[],...t.map(s=>sr(r,s)),...lr(r,e)]}function Pt(r){let e=()=>{let t=r.tool.value?.operation,n=t?.name==="paint"?r.settings.get(
t,"map"):null;r.appearance.instead.value=n==="tone"||n==="importance"?n:null};r.tool.on(e),r.settings.changed.on(e)}function Ne(r,e){return r.
knobs.some(t=>t.name===e)}function or(r){return[{name:"pan",title:"Pan",help:"Drag the paper about",key:"h",part:"look",operation:null,ring:!1,
begin:t=>{let{viewport:n}=r;return{move:o=>{let i=o[o.length-1],[s,a]=[(i.x-t.x)*n.scale,(i.y-t.y)*n.scale];n.pan(s/n.ratio,a/n.ratio)},end:()=>{},
cancel:()=>{}}}}]}function ve(r){return r.alt?"remove":r.shift?"add":"replace"}function ir(r,e){let t=(l,u,m,d={})=>{r.apply("select",{by:l,
mode:ve(u),path:m,...d,...r.ofLayer(e)})},n=(l,u,m,d,p=!1)=>({name:l,title:$(l),help:`${m}; Shift adds, Alt takes away`,key:u,part:"select",
operation:p?e:null,ring:p,begin:d}),o=(l,u)=>ve(u)==="replace"?ut(r,l):null,i=(l,u)=>{let m=[l.x,l.y,1];return o(l,u)??cr(()=>t("pick",u,m))},
s=(l,u)=>o(l,u)??ur(r,l,m=>t("rectangle",u,[l.x,l.y,1,m.x,m.y,1]),()=>t("pick",u,[l.x,l.y,1])),a=(l,u)=>Be(r,l,m=>t("lasso",u,m)),c=(l,u)=>{
let m=r.settings.get(e,"size"),d=r.newGroup(),p=0;return $e(l,{size:typeof m=="number"?m:5,lead:!1,least:1,lingers:!1,most:3*r.drawing.hello.
value.limits.path,send:f=>{let g=p++&&ve(u)==="replace"?"add":ve(u);return r.apply("select",{by:"brush",mode:g,path:f,size:m,...r.ofLayer(e)},
{group:d})}})};return[n("pick","v","Select the mark that you touch, and move or turn what is selected by its handles",i),n("rectangle","m","\
Select in a rectangle",s),n("lasso","l","Select inside an outline that you draw",a),n("select brush","q","Select under a brush",c,!0)]}function sr(r,e){
let t=(i,s)=>{let{settings:a}=r,c={...a.params(e),...r.ofLayer(e)},l=Number(a.get(e,"size")),u=e.name==="turn"?a.get(e,"by"):a.get(e,"turn"),
m=r.newGroup();return $e(i,{size:l,lead:e.name==="push"||e.name==="turn"&&u==="stroke",least:e.name==="insert"&&u==="stroke"?2:1,lingers:rr.
has(e.name),most:3*r.drawing.hello.value.limits.path,send:async d=>{let p=Ne(e,"on")?{on:"brush"}:{};if(!await r.apply(e.name,{...c,...s.alt?
ar(e,c):{},...p,size:l,path:d},{group:m}))throw new Error("refused")}})},{name:n,help:o}=e;return{name:n,title:$(n),help:o,key:St[n]??"",part:"\
brush",operation:e,ring:!0,begin:t}}function ar(r,e){let t=n=>e[n]??r.knobs.find(o=>o.name===n)?.default;return r.name==="resize"?{factor:1/
Number(t("factor"))}:r.name==="turn"?{angle:-Number(t("angle"))}:r.name==="freeze"?{frozen:!t("frozen")}:r.name==="paint"?{value:1-Number(t(
"value"))}:{}}function lr(r,e){let t=[],n=e.find(i=>i.name==="wall"),o={part:"outline",operation:null,ring:!1};if(n){let i=s=>Be(r,s,a=>{r.apply(
"wall",{path:a})});t.push({name:"wall",title:"Wall",help:"Draw an outline that relaxation does not cross",key:"w",...o,begin:i})}if(e.some(i=>i.
group==="style")){let i=s=>Be(r,s,a=>r.region.value=a);t.push({name:"region",title:"Region",help:"Draw the outline of what a style shall dra\
w anew",key:"d",...o,begin:i})}return t}function cr(r){return{move:()=>{},end:r,cancel:()=>{}}}function ur(r,e,t,n){let o=e;return{move:i=>o=
i[i.length-1],end:()=>Dt(r,e,o)<3?n():t(o),cancel:()=>{},draw:i=>{let[[s,a],[c,l]]=[r.viewport.px(e.x,e.y),r.viewport.px(o.x,o.y)];i.strokeRect(
s,a,c-s,l-a),i.fillRect(s,a,c-s,l-a)}}}function Be(r,e,t){let n=[e];return{move:o=>{for(let i of o)Dt(r,n[n.length-1],i)>=2&&n.push(i)},end:()=>{
let o=n.flatMap(i=>[Math.round(i.x*1e3)/1e3,Math.round(i.y*1e3)/1e3,1]);n.length>2&&t(o.slice(0,3*r.drawing.hello.value.limits.path))},cancel:()=>{},
draw:o=>{o.beginPath();for(let{x:i,y:s}of n)o.lineTo(...r.viewport.px(i,s));o.fill("evenodd"),o.stroke()}}}function Dt(r,e,t){return Math.hypot(
e.x-t.x,e.y-t.y)*r.viewport.scale/r.viewport.ratio}var hr=20,mr=4e3,It=40,ye=class{changed=new P;scale=1;x=0;y=0;width=1;height=1;ratio=1;paper=[100,100];get view(){return{scale:this.scale,x:this.
x,y:this.y}}mm(e,t){return[(e*this.ratio-this.x)/this.scale,(t*this.ratio-this.y)/this.scale]}px(e,t){return[(e*this.scale+this.x)/this.ratio,
(t*this.scale+this.y)/this.ratio]}resize(e,t,n){let o=n/this.ratio;[this.width,this.height,this.ratio]=[e,t,n],[this.scale,this.x,this.y]=[this.
scale*o,this.x*o,this.y*o],this.changed.say()}show(e){this.paper=e,this.fit({left:0,top:0,right:e[0],bottom:e[1]})}all(){this.fit({left:0,top:0,
right:this.paper[0],bottom:this.paper[1]})}fit(e){let t=It*this.ratio,[n,o]=[Math.max(e.right-e.left,.001),Math.max(e.bottom-e.top,.001)];this.
scale=this.bounded(Math.min((this.width-2*t)/n,(this.height-2*t)/o)),this.x=this.width/2-(e.left+e.right)/2*this.scale,this.y=this.height/2-
(e.top+e.bottom)/2*this.scale,this.changed.say()}pan(e,t){this.x+=e*this.ratio,this.y+=t*this.ratio,this.keep(),this.changed.say()}zoom(e,t=this.
width/this.ratio/2,n=this.height/this.ratio/2){let[o,i]=this.mm(t,n);this.scale=this.bounded(this.scale*e),this.x=t*this.ratio-o*this.scale,
this.y=n*this.ratio-i*this.scale,this.keep(),this.changed.say()}set(e){this.zoom(e/this.scale)}bounded(e){return Math.min(mr*this.ratio,Math.
max(hr/Math.max(...this.paper),e))}keep(){let e=It*this.ratio;this.x=Math.min(this.width-e,Math.max(e-this.paper[0]*this.scale,this.x)),this.
y=Math.min(this.height-e,Math.max(e-this.paper[1]*this.scale,this.y))}};var dr=[["cells","Voronoi cells"],["axes","Axes"],["flow","Flow of the picture"]],pr=300;function Ot(r,e){let{appearance:t}=r;return h("div",
{class:"panel"},h("h2",{},"Beneath"),Ct("Shown",t.under,[["picture","picture"],["tone","tone"],["importance","importance"],["none","nothing"]]),
fr("Opacity",t.opacity),h("h2",{},"Over it"),...dr.map(([n,o])=>gr(r,n,o,e)),we("Edge, margin and canvas",t.guides),we("Rulers",t.rulers),h(
"h2",{},"Page"),Ct("Colours",t.theme,[["system","as the system"],["light","light"],["dark","dark"]]),we("Shortcuts of one character",t.keys))}
function Ct(r,e,t){let n=h("select",{id:k("view"),change:()=>e.value=n.value},...t.map(([o,i])=>h("option",{value:o},i)));return e.on(o=>n.value=
o),h("div",{class:"knob"},h("label",{for:n.id},r),h("div",{class:"knob-inputs"},n))}function fr(r,e){let t=h("input",{type:"range",id:k("vie\
w"),min:0,max:1,step:.01,input:()=>e.value=t.valueAsNumber});return e.on(n=>t.value=String(n)),h("div",{class:"knob"},h("label",{for:t.id},r),
h("div",{class:"knob-inputs"},t))}function we(r,e){let t=h("input",{type:"checkbox",id:k("view"),change:()=>e.value=t.checked});return e.on(
n=>t.checked=n),h("div",{class:"knob knob-flag"},t,h("label",{for:t.id},r))}function gr(r,e,t,n){let o=new T(!1),i=-1,s=!1,a,c=async()=>{let u=r.
drawing.state.value;!o.value||s||!u||u.revision===i||u.busy&&!u.busy.paused||(s=!0,i=u.revision,await r.ask({do:"show",what:e,...r.layer.value===
null?{}:{layer:r.layer.value}})||(o.value=!1),s=!1,o.value||n(e))},l=()=>{clearTimeout(a),a=setTimeout(()=>{c()},pr)};return o.on(u=>{i=-1,u?
c():n(e)}),r.drawing.hello.on(()=>i=-1),r.drawing.changed.on(l),we(t,o)}function Ue(r,e){if(!("transferControlToOffscreen"in HTMLCanvasElement.prototype)){document.body.textContent="The editor needs a browser tha\
t paints in a thread of its own: Chromium 69, Firefox 105, Safari 16.4, or newer.";return}let t=new Worker(r),n=(m,d=[])=>t.postMessage(m,d),
o=new T(null);t.addEventListener("message",m=>o.value=m.data);let i=new me;t.addEventListener("error",m=>i.error(`The painter has failed: ${m.
message}. Load the page again; nothing is lost.`));let s=new he(e),a=new se(s,new le(s,n),new Z,new ye,i,new ne),c=new de(a);ft(a);let l=Et(
[{name:"Tool",panel:Lt(a)},{name:"Layers",panel:rt(a)},{name:"Relax",panel:bt(a)},{name:"Style",panel:xt(a)},{name:"History",panel:et(a)},{name:"\
View",panel:Ot(a,m=>n({do:"forget",what:m}))}]);a.tool.on(()=>l("Tool")),Pt(a),wt(a,n),_e(a,pt(a,c,new be(a)));let u="";a.drawing.begun(m=>a.
tools.value=At(a,m.operations)),a.drawing.hello.on(m=>{if(!m)return;let d=JSON.stringify([m.name,m.size,m.art]);d!==u&&(a.region.value=null),
u.startsWith(JSON.stringify([m.name]).slice(0,-1))||(a.layer.value=null),u=d;for(let p of m.notes)i.note(p)}),s.lost.on(m=>i.error(m)),Object.
assign(window,{crowquill:{desk:a,painted:o}}),br(a).finally(()=>s.connect())}async function br(r){let e=await r.link.wire.get("libraries.jso\
n");e&&(r.libraries=JSON.parse(await e.text()))}var _=-1,Ht=128,Q=class{constructor(e,t,n){this.side=n;this.columns=Math.max(1,Math.ceil(e/n)),this.rows=Math.max(1,Math.ceil(t/n)),this.head=
new Int32Array(this.columns*this.rows).fill(_)}side;columns;rows;head;next=new Int32Array(1024);back=new Int32Array(1024);column(e){return Math.
min(this.columns-1,Math.max(0,Math.floor(e/this.side)))}row(e){return Math.min(this.rows-1,Math.max(0,Math.floor(e/this.side)))}cell(e,t){return this.
row(t)*this.columns+this.column(e)}add(e,t){if(e>=this.next.length){let o=2**Math.ceil(Math.log2(e+1));this.next=O(this.next,new Int32Array(
o)),this.back=O(this.back,new Int32Array(o))}let n=this.head[t];this.next[e]=n,this.back[e]=~t,n!==_&&(this.back[n]=e),this.head[t]=e}remove(e){
let t=this.next[e],n=this.back[e];n<0?this.head[~n]=t:this.next[n]=t,t!==_&&(this.back[t]=n)}clear(){this.head.fill(_)}within(e,t,n,o,i){let s=0;
for(let a=this.row(t);a<=this.row(o);a++)for(let c=this.column(e);c<=this.column(n);c++)for(let l=this.head[a*this.columns+c];l!==_;l=this.next[l])
s===i.ids.length&&(i.ids=O(i.ids,new Int32Array(2*s))),i.ids[s++]=l;return s}};var Me=class{items=new G;kinds=new Map;layers=[];width=1;height=1;lines=new Map;grids=new Map;reaches=new Map;changed=new Q(1,1,1);stale=new Uint8Array(
1);begin(e,t){if(this.lines.clear(),this.width===e*1e3&&this.height===t*1e3)return this.touchAll();this.width=e*1e3,this.height=t*1e3,this.changed=
this.grid(),this.stale=new Uint8Array(this.changed.columns*this.changed.rows),this.reset()}reset(){this.items.clear(),this.kinds.clear(),this.
grids.clear(),this.reaches.clear(),this.stale.fill(1)}know(e){e.some(t=>this.kinds.has(t.id))&&this.stale.fill(1);for(let t of e)this.kinds.
set(t.id,new j(t.d,t.closed,t.reach))}list(e){let t=o=>JSON.stringify(o.map(i=>[i.id,i.rgb,i.pen,i.hidden])),n=t(e)!==t(this.layers);return this.
layers=e,n&&this.stale.fill(1),n}take(e){if(e.type==="lines"&&(this.lines.set(e.lines.what,new ze(e.lines,this.grid())),this.stale.fill(1)),
e.type!=="items")return;let{items:t}=this,n=i=>{this.gridOf(t.layer[i]).remove(i),this.touch(i)},o=i=>{let s=t.layer[i];this.gridOf(s).add(i,
this.changed.cell(t.x[i],t.y[i]));let a=this.reachOf(i);a>(this.reaches.get(s)??0)&&this.reaches.set(s,a),this.touch(i)};for(let i of e.chunks)
t.take(i,n,o)}forget(e){this.lines.delete(e)&&this.stale.fill(1)}reachOf(e){return(this.kinds.get(this.items.kind[e])?.reach??1)*this.items.
scale[e]}within(e,t,n,o,i,s){let a=this.grids.get(e),c=this.margin(e);return a?a.within(t-c,n-c,o+c,i+c,s):0}changedWithin(e,t,n,o){let i=Math.
max(0,...this.layers.map(c=>this.margin(c.id))),{changed:s,stale:a}=this;for(let c=s.row(t-i);c<=s.row(o+i);c++){let l=c*s.columns;for(let u=l+
s.column(e-i);u<=l+s.column(n+i);u++)if(a[u])return!0}return!1}settle(){this.stale.fill(0)}touchWithin(e,t,n,o){let{changed:i,stale:s}=this;
for(let a=i.row(t);a<=i.row(o);a++)s.fill(1,a*i.columns+i.column(e),a*i.columns+i.column(n)+1)}touchAll(){this.stale.fill(1)}margin(e){let t=this.
layers.find(n=>n.id===e)?.pen??0;return(this.reaches.get(e)??0)+500*t}touch(e){this.stale[this.changed.cell(this.items.x[e],this.items.y[e])]=
1}gridOf(e){let t=this.grids.get(e);return t||this.grids.set(e,t=this.grid()),t}grid(){return new Q(this.width,this.height,Math.max(this.width,
this.height)/Ht)}},ze=class{constructor(e,t){this.set=e;this.grid=t;let[n,o]=vr(e),i=new Uint32Array(t.columns*t.rows+1);this.cells(n,o,a=>i[a+
1]++);for(let a=1;a<i.length;a++)i[a]+=i[a-1];this.start=i.slice(),this.pieces=new Uint32Array(this.start[this.start.length-1]),this.ends=new Uint32Array(
this.pieces.length);let s=i;this.cells(n,o,(a,c)=>{this.pieces[s[a]]=n[c],this.ends[s[a]++]=o[c]})}set;grid;start;pieces;ends;within(e,t,n,o,i){
let{grid:s,set:a}=this;for(let c=s.row(t);c<=s.row(o);c++)for(let l=s.column(e);l<=s.column(n);l++){let u=c*s.columns+l;for(let m=this.start[u];m<
this.start[u+1];m++){let[d,p]=[2*this.pieces[m],2*this.ends[m]];i(a.xy[d],a.xy[d+1],a.xy[p],a.xy[p+1])}}}cells(e,t,n){let{grid:o,set:i}=this;
for(let s=0;s<e.length;s++){let[a,c]=[1e3*i.xy[2*e[s]],1e3*i.xy[2*e[s]+1]],[l,u]=[1e3*i.xy[2*t[s]],1e3*i.xy[2*t[s]+1]];for(let m=o.row(Math.
min(c,u));m<=o.row(Math.max(c,u));m++)for(let d=o.column(Math.min(a,l));d<=o.column(Math.max(a,l));d++)n(m*o.columns+d,s)}}};function vr(r){
let e=[],t=[];for(let n=0;n+1<r.start.length;n++){let[o,i]=[r.start[n],r.start[n+1]];for(let s=o;s+1<i;s++)e.push(s),t.push(s+1);r.closed&&i-
o>2&&(e.push(i-1),t.push(o))}return[Uint32Array.from(e),Uint32Array.from(t)]}var q=class{width=0;height=0;left=0;top=0;sums=new Float32Array(4096);over(e,t,n,o){this.left=e,this.top=t,this.width=n,this.height=o;let i=(n+
2)*o;i>this.sums.length?this.sums=new Float32Array(2*i):this.sums.fill(0,0,i)}fill(e,t){let n=t.x-this.left,o=t.y-this.top;for(let{xy:i}of e){
let s=i.length,a=n+t.cos*i[s-2]-t.sin*i[s-1],c=o+t.sin*i[s-2]+t.cos*i[s-1];for(let l=0;l<s;l+=2){let u=n+t.cos*i[l]-t.sin*i[l+1],m=o+t.sin*i[l]+
t.cos*i[l+1];this.edge(a,c,u,m),a=u,c=m}}}stroke(e,t,n){let o=Math.max(n,.05)/2,i=(s,a)=>[t.x-this.left+t.cos*s[a]-t.sin*s[a+1],t.y-this.top+
t.sin*s[a]+t.cos*s[a+1]];for(let{xy:s,closed:a}of e){let c=s.length;for(let l=a?0:2;l<c;l+=2){let[u,m]=i(s,(l+c-2)%c),[d,p]=i(s,l);this.capsule(
u,m,d,p,o)}c===2&&this.capsule(...i(s,0),...i(s,0),o)}}capsule(e,t,n,o,i){let s=i<.6?1:i<2?4:8,a=Math.atan2(o-t,n-e),c=[];for(let[l,u,m]of[[
n,o,a-Math.PI/2],[e,t,a+Math.PI/2]])for(let d=0;d<=s;d++){let p=m+Math.PI*d/s;c.push(l+i*Math.cos(p),u+i*Math.sin(p))}for(let l=0,u=c.length-
2;l<c.length;u=l,l+=2)this.edge(c[u],c[u+1],c[l],c[l+1])}edge(e,t,n,o){if(t===o)return;let i=1;if(t>o&&([e,t,n,o]=[n,o,e,t],i=-1),o<=0||t>=this.
height)return;let s=(n-e)/(o-t);t<0&&(e-=t*s,t=0),o>this.height&&(n-=(o-this.height)*s,o=this.height);let a=this.width,c=l=>(e-l)*(n-l)<0;if(c(
0))return this.twice(e,t,n,o,0,s,i);if(c(a))return this.twice(e,t,n,o,a,s,i);e>=a&&n>=a||(e<=0&&n<=0?this.rows(0,t,o,0,i):this.rows(e,t,o,s,
i))}twice(e,t,n,o,i,s,a){let c=t+(i-e)/s;a>0?(this.edge(e,t,i,c),this.edge(i,c,n,o)):(this.edge(n,o,i,c),this.edge(i,c,e,t))}rows(e,t,n,o,i){
let s=this.width+2,a=this.sums,c=e;for(let l=Math.floor(t);l<n;l++){let u=Math.max(t,l),d=Math.min(n,l+1)-u;if(d<=0)continue;let p=c+o*d,f=i*
d,[g,v]=c<p?[c,p]:[p,c],y=Math.floor(g),x=Math.ceil(v),L=l*s+y;if(x<=y+1){let E=(g+v)/2-y;a[L]+=f*(1-E),a[L+1]+=f*E}else{let E=1/(v-g),K=1-(g-
y),S=.5*E*K*K,C=v-x+1,I=.5*E*C*C;if(a[L]+=f*S,x===y+2)a[L+1]+=f*(1-S-I);else{let H=E*(1.5-(g-y));a[L+1]+=f*(H-S);for(let W=y+2;W<x-1;W++)a[l*
s+W]+=f*E;let te=H+(x-y-3)*E;a[l*s+x-1]+=f*(1-te-I)}a[l*s+x]+=f*I}c=p}}bytes(e){let t=this.width*this.height,n=e&&e.length>=t?e:new Uint8Array(
t),o=0;for(let i=0;i<this.height;i++){let s=0,a=i*(this.width+2);for(let c=0;c<this.width;c++)s+=this.sums[a+c],n[o++]=Math.min(1,Math.abs(s))*
255+.5|0}return n}};var Nt=6,Rt=48,We=1/64,Kt=16,B=4,yr=24e6,ke=new q,xe=class{kept=new Map;bytes=0;of(e,t,n,o,i,s){let a=Math.round(Math.log2(Math.max(We,o*e.reach)/
We)*Rt),c=We*2**(a/Rt),l=Math.max(1,Math.ceil(c*13)),u=Math.round(i/(2*Math.PI)*l)%l,[m,d]=[Math.min(B-1,Math.floor(t*B)),Math.min(B-1,Math.
floor(n*B))],p=Math.round(s*Kt),f=$t(this.kept,p,()=>new Map),g=$t(f,e,()=>new Map),v=(a*256+u)*B*B+d*B+m,y=g.get(v);if(y)return y;let x={x:(m+
.5)/B,y:(d+.5)/B},L=wr(e,x.x,x.y,c/e.reach,u/l*2*Math.PI,p/Kt);return this.bytes+=L.values.length+100,this.bytes>yr?this.clear():g.set(v,L),
L}clear(){this.kept.clear(),this.bytes=0}};function wr(r,e,t,n,o,i){let s=Math.ceil(r.reach*n+i/2+1),a=2*s+1;ke.over(-s,-s,a,a);let c={x:e,y:t,
cos:n*Math.cos(o),sin:n*Math.sin(o)};return i>0?ke.stroke(r.rings(n),c,i):ke.fill(r.rings(n),c),{left:-s,top:-s,width:a,height:a,values:ke.bytes()}}
function $t(r,e,t){let n=r.get(e);return n===void 0&&r.set(e,n=t()),n}var b=256,xr=2*Math.PI/65536,ee=class{values=new Uint8Array(b*b);left=b;top=b;right=0;bottom=0;get touched(){return this.left<this.right}clear(){
for(let e=this.top;e<this.bottom;e++)this.values.fill(0,e*b+this.left,e*b+this.right);this.left=this.top=b,this.right=this.bottom=0}touch(e,t,n,o){
e<this.left&&(this.left=e),t<this.top&&(this.top=t),n>this.right&&(this.right=n),o>this.bottom&&(this.bottom=o)}blend(e,t,n,o,i){let[s,a]=[Math.
max(0,-t),Math.min(o,b-t)],[c,l]=[Math.max(0,-n),Math.min(i,b-n)];if(s>=a||c>=l)return;this.touch(t+s,n+c,t+a,n+l);let{values:u}=this;for(let m=c;m<
l;m++){let d=(n+m)*b+t+s,p=m*o+a;for(let f=m*o+s;f<p;f++,d++){let g=e[f];if(g){let v=u[d];u[d]=v+((255-v)*g*257+32896>>16)}}}}line(e,t,n,o){
let i=Math.abs(o-t)>Math.abs(n-e);i&&([e,t,n,o]=[t,e,o,n]),e>n&&([e,t,n,o]=[n,o,e,t]);let s=n>e?(o-t)/(n-e):0,[a,c]=[Math.max(0,Math.floor(e)),
Math.min(b-1,Math.floor(n))];for(let l=a;l<=c;l++){let u=t+s*(Math.min(n,Math.max(e,l+.5))-e)-.5,m=Math.floor(u),d=u-m;this.most(i?m:l,i?l:m,
255*(1-d)),this.most(i?m+1:l,i?l:m+1,255*d)}this.touch(0,0,b,b)}most(e,t,n){if(e<0||t<0||e>=b||t>=b)return;let o=t*b+e;n>this.values[o]&&(this.
values[o]=n)}},Ee=class{image=new ImageData(b,b);ink=new ee;selected=new ee;frozen=new ee;sprites=new xe;coverage=new q;patch=new Uint8Array(
4096);found={ids:new Int32Array(4096)};paint(e,t,n,o,i){this.image.data.fill(0);let s=1e3/t,[a,c]=[n*b*s,o*b*s];for(let l of e.layers){if(l.
hidden)continue;let u=e.within(l.id,a,c,a+b*s,c+b*s,this.found);u&&this.layer(e,l,u,t,n*b,o*b),this.lay(this.ink,l.rgb),this.lay(this.frozen,
i.frozen),this.lay(this.selected,i.selected)}for(let l of e.lines.values())l.within(a,c,a+b*s,c+b*s,(u,m,d,p)=>this.ink.line(u*t-n*b,m*t-o*b,
d*t-n*b,p*t-o*b)),this.lay(this.ink,i.lines);return this.image}layer(e,t,n,o,i,s){let{items:a}=e,c=o/1e3;for(let l=0;l<n;l++){let u=this.found.
ids[l],m=e.kinds.get(a.kind[u]);if(!m)continue;let[d,p,f]=[a.x[u]*c-i,a.y[u]*c-s,a.scale[u]*c],g=t.pen===null?m.closed?0:1:Math.max(t.pen*o,
.1),v=m.reach*f,y=v+g/2+1;if(d+y<0||p+y<0||d-y>=b||p-y>=b)continue;let x=a.flags[u],L=a.fill[u],E=x&1?this.selected:x&2?this.frozen:this.ink,
K=L>=16777216&&E===this.ink;K&&this.lay(this.ink,t.rgb);let S=a.turn[u]*xr;if(v<=Nt){let[C,I]=[Math.floor(d),Math.floor(p)],H=this.sprites.of(
m,d-C,p-I,f,S,g);E.blend(H.values,C+H.left,I+H.top,H.width,H.height)}else{let[C,I]=[Math.max(0,Math.floor(d-y)),Math.max(0,Math.floor(p-y))],
[H,te]=[Math.min(b,Math.ceil(d+y)),Math.min(b,Math.ceil(p+y))];this.coverage.over(C,I,H-C,te-I);let W={x:d,y:p,cos:f*Math.cos(S),sin:f*Math.
sin(S)};g>0?this.coverage.stroke(m.rings(f),W,g):this.coverage.fill(m.rings(f),W),this.patch=this.coverage.bytes(this.patch),E.blend(this.patch,
C,I,H-C,te-I)}K&&this.lay(this.ink,[L>>16&255,L>>8&255,L&255])}}lay(e,t){if(!e.touched)return;let{data:n}=this.image,[o,i,s]=t,{values:a}=e;
for(let c=e.top;c<e.bottom;c++)for(let l=c*b+e.left;l<c*b+e.right;l++){let u=a[l];if(!u)continue;let m=4*l,p=n[m+3]*(255-u)/255,f=u+p;n[m]=(o*
u+n[m]*p)/f,n[m+1]=(i*u+n[m+1]*p)/f,n[m+2]=(s*u+n[m+2]*p)/f,n[m+3]=f}e.clear()}};var Er={tone:r=>[32,32,32,r],importance:r=>r>127?[120,30,170,Math.min(255,(r-127)*2)]:[0,120,60,(127-r)*2]},Le=class{images=new Map;size=[1,
1];art=[0,0,1,1];show(e,t){this.images.delete(e),t&&this.images.set(e,Lr(t))}forgetMaps(){this.images.delete("tone"),this.images.delete("imp\
ortance")}take(e){let t=this.images.get(e.map)?.[0],o=t instanceof OffscreenCanvas&&t.width===e.columns&&t.height===e.rows?t:new OffscreenCanvas(
e.columns,e.rows),i=new ImageData(e.width,e.height);for(let f=0;f<e.values.length;f++)i.data.set(Er[e.map](e.values[f]),4*f);o.getContext("2\
d").putImageData(i,e.left,e.top),this.images.set(e.map,[o]);let[s,a,c,l]=this.art.map(f=>f*1e3),[u,m]=[c/e.columns,l/e.rows],[d,p]=[s+(e.left-
1)*u,a+(e.top-1)*m];return[d,p,d+(e.width+2)*u,p+(e.height+2)*m]}draw(e,t,n,o,i,s){let[a,c]=this.size;e.fillStyle=i.paper,e.fillRect(-n,-o,a*
t,c*t),this.lay(e,i.under,this.art,t,n,o,i.opacity);for(let l of s)l.kind==="still"&&!l.hidden&&this.lay(e,l.id,[0,0,a,c],t,n,o,1)}lay(e,t,n,o,i,s,a){
let c=this.images.get(t);if(!c||!a)return;let l=n[2]*o,u=c.findLast(m=>m.width>=l)??c[0];e.globalAlpha=a,e.imageSmoothingEnabled=l<8*u.width,
e.drawImage(u,n[0]*o-i,n[1]*o-s,l,n[3]*o),e.globalAlpha=1}};function Lr(r){let e=[r];for(let t=r;Math.min(t.width,t.height)>128;){let n=new OffscreenCanvas(
Math.ceil(t.width/2),Math.ceil(t.height/2));n.getContext("2d").drawImage(t,0,0,n.width,n.height),e.push(t=n)}return e}var Tr=14,Sr=70,Ar=240,Ve=class{scene=new Me;underlay=new Le;tilePainter=new Ee;marks=new OffscreenCanvas(b,b);whole=new OffscreenCanvas(b,b);canvas=null;look=null;view={
scale:1,x:0,y:0};tiles={scale:0,all:new Map};before=null;zoomed=0;asked=!1;frames=0;coming=0;missing=0;revision=0;shown=0;take(e){switch(e.do){case"\
canvas":this.canvas=e.canvas;break;case"begin":this.scene.begin(...e.size),[this.underlay.size,this.underlay.art]=[e.size,e.art];break;case"\
state":e.reset&&(this.scene.reset(),this.underlay.forgetMaps()),this.scene.know(e.kinds),this.scene.list(e.layers),this.coming=e.revision,this.
missing=e.frames,this.arrive();break;case"frame":this.receive(e.buffer);break;case"view":this.see(e.view,e.width,e.height);break;case"look":
this.look=e.look,this.scene.touchAll();break;case"image":this.underlay.show(e.name,e.bitmap),this.scene.touchAll();break;case"forget":this.scene.
forget(e.what)}this.ask()}receive(e){let t=ae(e);if(t.type==="raster")for(let n of t.patches)this.scene.touchWithin(...this.underlay.take(n));else
this.scene.take(t);t.type!=="lines"&&(this.missing--,this.arrive())}arrive(){this.missing<=0&&(this.revision=this.coming)}see(e,t,n){this.canvas&&
(this.canvas.width!==t||this.canvas.height!==n)&&([this.canvas.width,this.canvas.height]=[t,n]),e.scale!==this.view.scale&&(this.zoomed=performance.
now()),this.view=e}ask(){this.asked||(this.asked=!0,requestAnimationFrame(()=>this.frame()))}frame(){this.asked=!1;let e=this.canvas?.getContext(
"2d",{alpha:!1});if(!e||!this.look)return;let t=performance.now(),n=t-this.zoomed>Sr||!this.tiles.all.size;n&&this.tiles.scale!==this.view.scale&&
this.change(),this.mark();let o=n?this.make(t+Tr):1;this.draw(e),o?this.ask():(this.before=Bt(this.before),this.shown=this.revision),this.frames++;
let i=performance.now(),s={revision:this.shown,frames:this.frames,cost:i-t,at:performance.timeOrigin+i};postMessage(s)}change(){[...this.tiles.
all.values()].some(t=>t.bitmap)&&(Bt(this.before),this.before=this.tiles),this.tiles={scale:this.view.scale,all:new Map}}mark(){let e=b*1e3/
this.tiles.scale;for(let t of this.tiles.all.values()){if(!t.fresh)continue;let[n,o]=[t.column*e,t.row*e];t.fresh=!this.scene.changedWithin(
n,o,n+e,o+e)}this.scene.settle()}make(e){let t=this.inSight().filter(c=>!c.fresh),{canvas:n,view:o}=this,[i,s]=[(n.width/2-o.x)/b-.5,(n.height/
2-o.y)/b-.5];t.sort((c,l)=>Math.hypot(c.column-i,c.row-s)-Math.hypot(l.column-i,l.row-s));let a=0;for(let c of t)if(this.paint(c),a++,performance.
now()>e)break;return this.forget(),t.length-a}paint(e){let{scale:t}=this.tiles,[n,o]=[e.column*b,e.row*b],i=this.tilePainter.paint(this.scene,
t,e.column,e.row,this.look.tints);this.marks.getContext("2d",{willReadFrequently:!0}).putImageData(i,0,0);let s=this.whole.getContext("2d",{
willReadFrequently:!0});s.clearRect(0,0,b,b),this.underlay.draw(s,t,n,o,this.look,this.scene.layers),s.drawImage(this.marks,0,0),e.bitmap?.close(),
e.bitmap=this.whole.transferToImageBitmap(),e.fresh=!0}inSight(){let{view:e,tiles:t,canvas:n,scene:o}=this;if(t.scale!==e.scale)return[];let i=(a,c,l)=>Math.
floor(Math.min(a/1e3*e.scale+8,c-l)/b),s=[];for(let a=Math.max(-1,Math.floor(-e.y/b));a<=i(o.height,n.height,e.y);a++)for(let c=Math.max(-1,
Math.floor(-e.x/b));c<=i(o.width,n.width,e.x);c++){let l=(a+1)*1e6+c+1,u=t.all.get(l);u||t.all.set(l,u={column:c,row:a,bitmap:null,fresh:!1}),
s.push(u)}return s}forget(){if(this.tiles.all.size<=Ar)return;let e=new Set(this.inSight());for(let[t,n]of this.tiles.all)e.has(n)||(n.bitmap?.
close(),this.tiles.all.delete(t))}draw(e){let{view:t,look:n,scene:o}=this,{width:i,height:s}=e.canvas;e.fillStyle=n.desk,e.fillRect(0,0,i,s);
let[a,c]=[Math.round(t.x),Math.round(t.y)];e.fillStyle=n.paper,e.fillRect(a,c,o.width/1e3*t.scale,o.height/1e3*t.scale);for(let l of[this.before,
this.tiles]){if(!l)continue;let u=t.scale/l.scale,m=b*u;for(let{column:d,row:p,bitmap:f}of l.all.values()){let[g,v]=[a+d*m,c+p*m];!f||g>=i||
v>=s||g+m<=0||v+m<=0||(u===1?e.drawImage(f,g,v):e.drawImage(f,g,v,m,m))}}}};function Bt(r){for(let e of r?.all.values()??[])e.bitmap?.close();
return null}function Ut(){let r=new Ve;addEventListener("message",e=>r.take(e.data))}function zt(){return{open(){let r=new WebSocket(new URL("socket",location.href.replace(/^http/,"ws")));return r.binaryType="arraybuffer",r},
async get(r){let e=await fetch(new URL(r,location.href));return e.ok?e.blob():null}}}var Fe=class extends EventTarget{constructor(t){super();
this.tell=t;queueMicrotask(()=>{t({open:!0}),this.readyState=WebSocket.OPEN,this.dispatchEvent(new Event("open"))})}tell;readyState=WebSocket.
CONNECTING;send(t){this.tell({text:t})}hear(t){this.dispatchEvent(new MessageEvent("message",{data:t}))}close(t=1e3){this.readyState=WebSocket.
CLOSED,this.dispatchEvent(new CloseEvent("close",{code:t}))}};function Wt(r){let e=null,t=new Map,n=o=>r.postMessage(o);return r.onmessage=({
data:o})=>{if("text"in o)e?.hear(o.text);else if("frame"in o)e?.hear(o.frame);else if("closed"in o)e?.close(o.closed);else{for(let i of t.get(
o.got)??[])i(o.data&&new Blob([o.data],{type:o.type}));t.delete(o.got)}},{open:()=>e=new Fe(n),get:o=>new Promise(i=>{t.set(o,[...t.get(o)??
[],i]),n({get:o})})}}if(typeof document>"u")Ut();else{let r=document.currentScript;if(r.src)Ue(r.src,zt());else{let e=URL.createObjectURL(new Blob([r.textContent??
""],{type:"text/javascript"}));window.addEventListener("message",t=>t.ports[0]&&Ue(e,Wt(t.ports[0])),{once:!0})}}})();
