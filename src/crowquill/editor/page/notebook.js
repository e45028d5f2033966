function f({model:e,el:c}){let o=`${Date.now()} ${Math.random()}`,n=document.createElement("iframe"),r=new MessageChannel,s=(t,a)=>{if(t.view!==
o)return;let i=a[0]?g(a[0]):null,d="frame"in t?{frame:i}:"got"in t?{...t,data:i}:t;r.port1.postMessage(d)};return r.port1.onmessage=({data:t})=>e.
send({view:o,...t}),e.on("msg:custom",s),n.title="Crowquill's editor",Object.assign(n.style,{width:"100%",height:`${Number(e.get("height"))}\
px`,border:"0"}),n.addEventListener("load",()=>n.contentWindow.postMessage("crowquill","*",[r.port2]),{once:!0}),n.srcdoc=String(e.get("page")),
c.append(n),()=>{e.off("msg:custom",s),e.send({view:o,close:!0}),r.port1.close()}}function g(e){return e.buffer.slice(e.byteOffset,e.byteOffset+
e.byteLength)}var u={render:f};export{u as default};
