"""Serve an endless texture to a browser: python examples/window_server.py, then open http://127.0.0.1:8000/

Every tile /X/Y.png (256 px, X and Y may be negative) is a window, drawn when it is asked for; nothing is stored.
"""

from __future__ import annotations

import re
import threading
import urllib.request
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import intarsia as ia
from intarsia.files import encode

TILE = 256
PAGE = b"""<!doctype html><title>An endless texture</title><style>body{margin:0;overflow:hidden;cursor:move}
img{position:absolute}</style><script>let x=0,y=0;const all={};function show(){for(let i=Math.floor(x/256)-1;i*256<
x+innerWidth+256;i++)for(let j=Math.floor(y/256)-1;j*256<y+innerHeight+256;j++){const k=`/${i}/${j}.png`;if(!all[k]){
all[k]=document.body.appendChild(new Image());all[k].src=k;all[k].draggable=false;all[k].at=[i,j]}}for(const k in all){
const[i,j]=all[k].at;all[k].style.left=i*256-x+'px';all[k].style.top=j*256-y+'px'}}onmousemove=e=>{if(e.buttons){
x-=e.movementX;y-=e.movementY;show()}};onresize=onload=show</script>"""


def server(texture: ia.Weave, port: int = 0) -> ThreadingHTTPServer:
    """Return a server of this computer alone; port 0 takes any that is free."""

    class Windows(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            tile = re.fullmatch(r"/(-?\d{1,9})/(-?\d{1,9})\.png", self.path)
            if tile is None and self.path != "/":
                self.send_error(404)
                return
            data = PAGE
            if tile is not None:
                x, y = TILE * int(tile[1]), TILE * int(tile[2])
                data = encode(texture.like.like(texture[y : y + TILE, x : x + TILE]), "png")
            self.send_response(200)
            self.send_header("Content-Type", "text/html" if tile is None else "image/png")
            self.end_headers()
            self.wfile.write(data)

    return ThreadingHTTPServer(("127.0.0.1", port), Windows)


def main(size: int = 512, folder: Path = Path("demo")) -> Path:
    """Fetch one tile, far away, from a server that runs meanwhile."""
    folder.mkdir(exist_ok=True)
    with server(ia.weave(ia.Exemplar.of(ia.read("sample:tiles").base.pixels[:size, :size]), seed=7)) as running:
        threading.Thread(target=running.serve_forever, daemon=True).start()
        with urllib.request.urlopen(f"http://127.0.0.1:{running.server_port}/-4000000/17.png") as answer:
            (folder / "window.png").write_bytes(answer.read())
        running.shutdown()
    return folder / "window.png"


if __name__ == "__main__":
    server(ia.weave("sample:tiles", seed=7), 8000).serve_forever()
