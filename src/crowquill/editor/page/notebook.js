function g({model:e,el:d}){let r=`${Date.now()} ${Math.random()}`,n=document.createElement("iframe"),o=new MessageChannel,i=(t,c)=>{if(t.view!==
r)return;let f=c[0]?u(c[0]):null,l="frame"in t?{frame:f}:"got"in t?{...t,data:f}:t;o.port1.postMessage(l)},s=!0,a=()=>{s=!1,o.port1.postMessage(
{closed:1001})};return o.port1.onmessage=({data:t})=>s&&e.send({view:r,...t}),e.on("msg:custom",i),e.on("comm_live_update",a),n.title="Crowq\
uill's editor",Object.assign(n.style,{width:"100%",height:`${Number(e.get("height"))}px`,border:"0"}),n.addEventListener("load",()=>n.contentWindow.
postMessage("crowquill","*",[o.port2]),{once:!0}),n.srcdoc=String(e.get("page")),d.append(n),()=>{e.off("msg:custom",i),e.off("comm_live_upd\
ate",a),s&&e.send({view:r,close:!0}),o.port1.close()}}function u(e){return e.buffer.slice(e.byteOffset,e.byteOffset+e.byteLength)}var m={render:g};export{m as default};
