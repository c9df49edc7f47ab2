"""The sandbox window beside a script, and pictures of models: both by the program `gelenk`."""

import json
import os
import shutil
import struct
import subprocess
import tempfile
import threading
import zlib
from pathlib import Path

import numpy as np

from . import _gelenk


def program():
    """Path of the program `gelenk`: GELENK_PROGRAM, the one that was installed with the package, or the one on PATH."""
    here = Path(__file__).resolve().parent
    for path in (os.environ.get("GELENK_PROGRAM"), here / "bin" / "gelenk", here.parent.parent / "gelenk",
                 shutil.which("gelenk")):
        if path and os.access(path, os.X_OK) and Path(path).is_file():
            return str(path)
    raise FileNotFoundError("the program gelenk is not there: build it with graphics, or name it in GELENK_PROGRAM")


def _write_scene(model, q, folder, handles=True, theme=None):
    """The file that the program opens to have this model in this pose."""
    if not isinstance(model, _gelenk.Model):
        raise TypeError(f"expected a Model, found {type(model).__name__}")
    tree = json.loads(model._scene)
    if isinstance(tree.get("model"), dict):
        _absolute(tree["model"])
    if q is not None:
        q = np.asarray(q, dtype=float)
        if q.shape != (model.nq,):  # fk would take several
            raise ValueError(f"q: expected shape ({model.nq},), found {q.shape}")
        model.fk(q)  # says what is wrong with it
        tree["q"] = q.tolist()
    if not handles and "show" in tree.get("view", {}):
        tree["view"]["show"]["handles"] = False
    if theme not in (None, "light", "dark"):
        raise ValueError(f"a theme is light or dark, not '{theme}'")
    if theme:
        tree.setdefault("view", {})["theme"] = theme
    path = Path(folder) / "scene.json"
    path.write_text(json.dumps(tree))
    return path


def _absolute(entry):
    """Paths of a scene's files, wherever the program is started."""
    for key, value in entry.items():
        if isinstance(value, dict):
            _absolute(value)
        elif isinstance(value, str) and 0 < len(value) < 4096 and os.path.exists(value):
            entry[key] = os.path.abspath(value)


class Picture(np.ndarray):
    """A picture as an array: (height, width, 3) uint8, from the upper left. A notebook shows it."""

    def _repr_png_(self):
        if self.ndim != 3 or self.shape[2] != 3 or self.dtype != np.uint8:  # a part of one that is none
            return None

        def chunk(name, data):
            return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

        rows = b"".join(b"\0" + row.tobytes() for row in self)  # each unfiltered
        head = struct.pack(">IIBBBBB", self.shape[1], self.shape[0], 8, 2, 0, 0, 0)  # 8 bits of red, green, blue
        return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")

    def save(self, path):
        """Writes it as .png."""
        if not str(path).endswith(".png"):
            raise ValueError(f"'{path}': a picture is saved as .png")
        data = self._repr_png_()
        if data is None:
            raise ValueError(f"an array {self.shape} of {self.dtype} is no picture")
        Path(path).write_bytes(data)


class View:
    """A sandbox window in its own process. It closes with the script, unless keep=True."""

    def __init__(self, model, q=None, solver="drag", theme=None, size=(1280, 800), keep=False, offscreen=False):
        self.model = model
        self._folder = tempfile.TemporaryDirectory()
        scene = _write_scene(model, q, self._folder.name, theme=theme)
        words = [program(), "sandbox", str(scene), "--remote", "--size", f"{size[0]}x{size[1]}"]
        if offscreen:
            words.append("--offscreen")
        self._process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1)
        self._begin()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self._own_solvers()
        self._ask("events")
        if keep:
            self._ask("keep")
        self.solver = solver

    # ---- messages

    def _begin(self):
        self._lock, self._changed = threading.Lock(), threading.Condition()
        self._replies, self._last, self._pose, self._closed = {}, 0, None, False
        self.on_change = None

    def _send(self, message):
        try:
            with self._lock:
                self._process.stdin.write(json.dumps({"gelenk": 1, **message}) + "\n")
                self._process.stdin.flush()
        except (OSError, ValueError):
            raise RuntimeError("the window is closed") from None

    def _ask(self, do, **fields):
        with self._changed:
            self._last += 1
            number = self._last
        self._send({"id": number, "do": do, **fields})
        with self._changed:
            if not self._changed.wait_for(lambda: number in self._replies or self._closed, timeout=60):
                raise RuntimeError("the window does not answer")
            if number not in self._replies:
                raise RuntimeError("the window is closed")
            reply = self._replies.pop(number)
        if not reply.get("ok"):
            raise ValueError(reply.get("error", "the window refused"))
        return reply

    def _read(self):
        for line in self._process.stdout:
            message = json.loads(line)
            if message.get("event") == "solve":
                threading.Thread(target=self._solve, args=(message,), daemon=True).start()
                continue
            self._take(message)
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def _take(self, message):
        with self._changed:
            if message.get("event") == "pose":
                self._pose = message
            elif "id" in message:
                self._replies[message["id"]] = message
            self._changed.notify_all()
        if message.get("event") == "pose" and self.on_change:
            self.on_change(self)

    def _solve(self, message):
        """A solver of this process, asked by the window."""
        answer = {"do": "solved", "of": message["of"]}
        try:
            words = {name.replace("-", "_") + "_": value for name, value in (message["parameters"] or {}).items()}
            result = _gelenk.solve(self.model, list(message["goals"]), solver=message["solver"],
                                   start=np.array(message["q"]), tolerance=message["tolerance"],
                                   max_iterations=message["max_iterations"], restarts=0, **words)
            answer.update(q=result.q.tolist(), iterations=result.iterations)
        except Exception as error:  # the window goes on; the script's author reads it
            import traceback

            traceback.print_exception(error)
        try:
            self._send(answer)
        except RuntimeError:
            pass

    def _own_solvers(self):
        for entry in _gelenk.solvers():
            if entry["reference"] == "own":
                parameters = [{k: p[k] for k in ("name", "value", "lower", "upper")} for p in entry["parameters"]]
                self._ask("solver", name=entry["name"], title=entry["title"], parameters=parameters)

    def _now(self):
        return self._ask("get")

    # ---- what a script sets and reads

    @property
    def closed(self):
        """Whether the window is gone."""
        return self._closed or self._process.poll() is not None

    @property
    def q(self):
        """(nq,) the pose in the window; setting it poses the model, and goals that are held go along."""
        return np.array(self._now()["q"])

    @q.setter
    def q(self, q):
        q = np.asarray(q, dtype=float)
        self.model.fk(q)
        self._ask("set", q=q.tolist())

    @property
    def solver(self):
        """Name of the solver that follows the goals; setting it takes parameters in brackets too, dls[lambda=0.1]."""
        return self._now()["solver"]

    @solver.setter
    def solver(self, text):
        if any(e["name"] == text.split("[")[0] and e["reference"] == "own" for e in _gelenk.solvers()):
            self._own_solvers()
        self._ask("set", solver=text)

    @property
    def goals(self):
        """The goals in the window: dicts of name, state, target and reached (3,), error (metres), pixel; what a person drags changes them."""
        return self._now()["goals"]

    def set_goal(self, joint, target=None, state="held"):
        """Holds, pins or frees ('held', 'pinned', 'free') a joint's goal, at a target (3,) where given."""
        wanted = {"name": joint, "state": state}
        if target is not None:
            wanted["target"] = np.asarray(target, dtype=float).tolist()
        self._ask("set", goals=[wanted])

    def add_goal(self, goal):
        """Adds a Goal of any kind."""
        self._ask("set", goals=[{"goal": goal if isinstance(goal, str) else goal.text(self.model)}])

    def play(self, clip, speed=1.0):
        """Plays a Clip, frame by frame in its own time; returns when it is over or the window closed."""
        import time

        begin = time.monotonic()
        while not self.closed:
            t = speed * (time.monotonic() - begin)
            self.q = clip.sample(min(t, clip.duration))
            if t >= clip.duration:
                return
            time.sleep(1 / 60)

    def wait_for_change(self, timeout=None):
        """The next pose that the window tells, a dict of q, goals, dragging, error, reached; None after the timeout or where
        it closed."""
        with self._changed:
            before = self._pose
            self._changed.wait_for(lambda: self._pose is not before or self._closed, timeout)
            return None if self._closed or self._pose is before else dict(self._pose)

    def wait(self):
        """Until the window is closed."""
        self._process.wait()

    def scene(self):
        """The scene as text, as the window would save it."""
        return self._ask("scene")["text"]

    def _repr_png_(self):
        """What the window shows, as a notebook puts it below a cell; None where it is closed."""
        if self.closed:
            return None
        scene, picture = Path(self._folder.name) / "now.json", Path(self._folder.name) / "now.png"
        scene.write_text(self.scene())
        _run([program(), "render", str(scene), "-o", str(picture), "--size", "800x500"])
        return picture.read_bytes()

    def close(self):
        """Closes the window."""
        if not self.closed:
            try:
                self._ask("close")
            except RuntimeError:
                pass
        try:
            self._process.stdin.close()
        except OSError:
            pass
        try:
            self._process.wait(timeout=10)
        except subprocess.TimeoutExpired:
            self._process.terminate()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def show(model, q=None, *, solver="drag", theme=None, size=(1280, 800), keep=False, offscreen=False):
    """Opens the sandbox window on a model in a process of its own: a View.

    q: (nq,) the pose; default the model's. solver: what follows the goals while a person drags, own ones too. keep: the
    window stays when the script ends. offscreen: without a window, for tests and servers.
    """
    return View(model, q, solver, theme, size, keep, offscreen)


def render(model, q=None, *, size=(1280, 800), scale=1.0, theme=None, view=None, azimuth=None, elevation=None, zoom=1.0,
           bones=False, wireframe=False, handles=False, ground=True, shadow=True):
    """A picture of a model: a Picture, (height, width, 3) uint8.

    view: 'front', 'side', 'top', 'three-quarter'; azimuth, elevation: degrees. bones: drawn through the skin; handles: where it is dragged.
    """
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder) / "picture.ppm"
        scene = _write_scene(model, q, folder, handles, theme)
        words = [program(), "render", str(scene), "-o", str(picture), "--size", f"{size[0]}x{size[1]}", "--scale", str(scale),
                 "--zoom", str(zoom)]
        for flag, wanted in (("--bones", bones), ("--wireframe", wireframe), ("--no-ground", not ground),
                             ("--no-shadow", not shadow)):
            words += [flag] * bool(wanted)
        for option, value in (("--view", view), ("--azimuth", azimuth), ("--elevation", elevation)):
            words += [option, str(value)] * (value is not None)
        _run(words)
        return _read_ppm(picture.read_bytes())


def _run(words):
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode != 0:
        raise ValueError(_reason(done.stderr) or f"the program ended with {done.returncode}")


def _reason(told):
    """The error's sentence among what the program told on standard error: without notes about files, and where to read on."""
    lines = [line for line in told.splitlines() if not line.startswith(("note: ", "Run with --help"))]
    return "\n".join(lines).strip().removeprefix("gelenk: ")


def _read_ppm(data):
    """P6: width, height, 255 and the pixels."""
    magic, width, height, most, _ = data.split(None, 4)
    assert magic == b"P6" and most == b"255"
    pixels = np.frombuffer(data, np.uint8)[-3 * int(width) * int(height):]
    return pixels.reshape(int(height), int(width), 3).copy().view(Picture)
