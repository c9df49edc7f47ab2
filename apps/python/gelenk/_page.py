"""The sandbox's page below a notebook's cell: served by this process and driven by its messages (docs/web.md)."""

import http.server
import json
import os
import queue
import secrets
import tempfile
import threading
from functools import partial
from pathlib import Path

from ._show import View, _write_scene

frame = """<!doctype html><meta charset="utf-8"><title>Gelenk</title>
<style>html, body, iframe { margin: 0; width: 100%; height: 100%; border: 0; display: block; overflow: hidden }</style>
<iframe src="../index.html?panel=off&theme=THEME"></iframe>
<script>
const page = document.querySelector('iframe').contentWindow;
addEventListener('message', ({source, data}) => {
  if (source !== page) return;
  if (data.event !== 'ready') return fetch('told', {method: 'POST', body: JSON.stringify(data)});
  new EventSource('tell').onmessage = (message) => page.postMessage(JSON.parse(message.data), location.origin);
});
</script>
"""


class Handler(http.server.SimpleHTTPRequestHandler):
    """The page's files; the frame around it; what is told to it (a stream) and by it."""

    def __init__(self, *words, page, **named):
        self.page = page
        super().__init__(*words, **named)

    def do_GET(self):
        if self.path == f"/{self.page._key}/frame":
            self.answer("text/html; charset=utf-8", frame.replace("THEME", self.page._theme).encode())
        elif self.path == f"/{self.page._key}/tell":
            self.tell()
        else:
            super().do_GET()

    def do_POST(self):
        if self.path != f"/{self.page._key}/told":
            return self.send_error(404)
        self.page._take(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
        self.answer("text/plain", b"")

    def answer(self, kind, body):
        self.send_response(200)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def tell(self):
        self.send_response(200)
        self.send_header("Content-Type", "text/event-stream")
        self.end_headers()
        messages = self.page._open()
        try:
            while (message := messages.get()) is not None:
                self.wfile.write(f"data: {message}\n\n".encode())
                self.wfile.flush()
        except OSError:  # it was closed
            pass
        finally:
            self.page._shut(messages)

    def log_message(self, *_):
        pass


class Page(View):
    """The sandbox as a page, alive below a notebook's cell or in any browser of this machine at .address; set and read like
    the window: q, goals, solver, set_goal, wait_for_change."""

    def __init__(self, model, q, theme, height, site):
        self.model, self._height, self._theme, self._key = model, height, theme or "light", secrets.token_hex(8)
        with tempfile.TemporaryDirectory() as folder:
            self._scene = _write_scene(model, q, folder, theme=theme).read_text()
        self._begin()
        self._open_ones = []
        self._server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), partial(Handler, directory=str(site), page=self))
        self._server.daemon_threads = True
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        self.address = f"http://127.0.0.1:{self._server.server_port}/{self._key}/frame"

    def _open(self):
        """The messages for one more browser: the model in its pose comes first."""
        messages = queue.Queue()
        messages.put(json.dumps({"gelenk": 1, "do": "load", "text": self._scene}))
        if self._pose:
            messages.put(json.dumps({"gelenk": 1, "do": "set", "q": self._pose["q"]}))
        messages.put(json.dumps({"gelenk": 1, "do": "events"}))
        with self._changed:
            self._open_ones.append(messages)
            self._changed.notify_all()
        return messages

    def _shut(self, messages):
        with self._changed:
            self._open_ones.remove(messages)

    def _send(self, message):
        with self._changed:
            if self._closed:
                raise RuntimeError("the page is closed")
            if not self._open_ones:
                raise RuntimeError("no browser shows the page yet: end a cell with it, or open its address")
            for messages in self._open_ones:
                messages.put(json.dumps({"gelenk": 1, **message}))

    @property
    def closed(self):
        """Whether close() was called."""
        return self._closed

    def wait(self):
        """Until close() is called, from another thread."""
        with self._changed:
            self._changed.wait_for(lambda: self._closed)

    def close(self):
        """Serves it no longer."""
        with self._changed:
            if self._closed:
                return
            self._closed = True
            for messages in self._open_ones:
                messages.put(None)
            self._changed.notify_all()
        self._server.shutdown()
        self._server.server_close()

    def _repr_png_(self):
        return None

    def _repr_html_(self):
        return f'<iframe src="{self.address}" style="width: 100%; height: {self._height}px; border: 0"></iframe>'


def embed(model, q=None, *, theme=None, height=560, site=None):
    """The sandbox below a notebook's cell: a Page, which this process serves to browsers of this machine.

    q: (nq,) the pose; height: pixels. site: the folder of the page that ./web.sh has built; default GELENK_PAGE, or build-web/site of
    the tree that the module was built in. Solvers of one's own do not run in it; gelenk.show runs them.
    """
    site = Path(site or os.environ.get("GELENK_PAGE") or Path(__file__).resolve().parents[3] / "build-web" / "site")
    if not (site / "gelenk.wasm").is_file():
        raise FileNotFoundError(f"'{site}' holds no page: build it with ./web.sh, and name its folder as site= or in GELENK_PAGE")
    return Page(model, q, theme, height, site)
