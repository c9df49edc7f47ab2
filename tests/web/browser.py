"""A headless chromium driven through its devtools protocol, over a pipe; and a file server. The standard library alone."""
import base64
import contextlib
import functools
import http.server
import json
import os
import select
import shutil
import subprocess
import tempfile
import threading
import time


class Browser:
    flags = ['--headless=new', '--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
             '--disable-component-update', '--disable-sync', '--disable-extensions', '--mute-audio', '--disable-dev-shm-usage', '--disable-gpu-watchdog', '--hide-scrollbars',
             '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist', '--remote-debugging-pipe']

    def __init__(self, *more):
        self.folder = tempfile.mkdtemp(prefix='gelenk-browser-')
        self.downloads = os.path.join(self.folder, 'downloads')
        to_read, self.out = os.pipe()
        self.into, to_write = os.pipe()

        def place():  # chromium reads from 3 and writes to 4
            a, b = os.dup(to_read), os.dup(to_write)
            os.dup2(a, 3)
            os.dup2(b, 4)

        self.process = subprocess.Popen(['chromium', *self.flags, *more, f'--user-data-dir={self.folder}/profile', 'about:blank'],
                                        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                        preexec_fn=place, close_fds=False, start_new_session=True)
        os.close(to_read)
        os.close(to_write)
        self.rest, self.last, self.replies, self.console, self.events = b'', 0, {}, [], []
        target = next(t for t in self.send('Target.getTargets')['targetInfos'] if t['type'] == 'page')
        self.session = self.send('Target.attachToTarget', targetId=target['targetId'], flatten=True)['sessionId']
        self.send('Browser.setDownloadBehavior', behavior='allow', downloadPath=self.downloads)
        for domain in ('Page', 'Runtime', 'Log', 'Network'):
            self.send(f'{domain}.enable')

    def close(self):
        with contextlib.suppress(Exception):
            self.send('Browser.close')
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
        shutil.rmtree(self.folder, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    # ---- the protocol

    def send(self, method, **parameters):
        self.last += 1
        message = {'id': self.last, 'method': method, 'params': parameters}
        if getattr(self, 'session', None) and not method.startswith(('Browser.', 'Target.')):
            message['sessionId'] = self.session
        os.write(self.out, json.dumps(message).encode() + b'\0')
        until = time.monotonic() + 240
        while self.last not in self.replies:
            self._receive(until - time.monotonic(), method)
        reply = self.replies.pop(self.last)
        assert 'error' not in reply, (method, reply['error'])
        return reply['result']

    def _receive(self, seconds, what):
        assert seconds > 0 and select.select([self.into], [], [], seconds)[0], f'no answer to {what}'
        chunk = os.read(self.into, 1 << 20)
        assert chunk, 'the browser has ended'
        *whole, self.rest = (self.rest + chunk).split(b'\0')
        for text in whole:
            message = json.loads(text)
            if 'id' in message:
                self.replies[message['id']] = message
                continue
            what, p = message['method'], message['params']
            self.events.append((what, p))
            if what == 'Runtime.consoleAPICalled' and p['type'] in ('error', 'warning', 'assert'):
                self.console.append(' '.join(str(a.get('value', a.get('description', ''))) for a in p['args']))
            if what == 'Runtime.exceptionThrown':
                self.console.append(p['exceptionDetails'].get('exception', {}).get('description', p['exceptionDetails']['text']))
            if what == 'Log.entryAdded' and p['entry']['level'] in ('error', 'warning'):
                self.console.append(p['entry']['text'] + ' ' + p['entry'].get('url', ''))

    # ---- pages

    def open(self, address):
        self.send('Page.navigate', url='about:blank')
        self.send('Page.navigate', url=address)

    def evaluate(self, script, **more):
        done = self.send('Runtime.evaluate', expression=script, returnByValue=True, awaitPromise=True, **more)
        assert 'exceptionDetails' not in done, (script, done['exceptionDetails'])
        return done['result'].get('value')

    def wait(self, script, seconds=90):
        """Until the script gives something true, which is returned."""
        until = time.monotonic() + seconds
        while True:
            value = self.evaluate(script)
            if value:
                return value
            assert time.monotonic() < until, f'waited {seconds} s for {script}; console: {self.console}'
            time.sleep(0.05)

    def picture(self, path):
        data = self.send('Page.captureScreenshot', format='png')['data']
        with open(path, 'wb') as file:
            file.write(base64.b64decode(data))

    def size(self, width, height, ratio=1):
        self.send('Emulation.setDeviceMetricsOverride', width=width, height=height, deviceScaleFactor=ratio, mobile=False)

    # ---- a person

    def mouse(self, kind, x, y, button='left', **more):
        self.send('Input.dispatchMouseEvent', type=kind, x=x, y=y, button=button,
                  buttons=1 if kind == 'mousePressed' or more.pop('held', False) else 0, clickCount=1 if kind != 'mouseMoved' else 0, **more)

    def touch(self, kind, *points):
        self.send('Input.dispatchTouchEvent', type=kind, touchPoints=[{'x': x, 'y': y, 'id': i} for i, (x, y) in enumerate(points)])

    def key(self, key, code, number, control=False, shift=False, alt=False, kinds=('rawKeyDown', 'keyUp'), **more):
        for kind in kinds:
            self.send('Input.dispatchKeyEvent', type=kind, key=key, code=code, windowsVirtualKeyCode=number,
                      modifiers=alt | 2 * control | 8 * shift, **(more if kind != 'keyUp' else {}))

    def type(self, text):
        for c in text:
            for kind in ('keyDown', 'keyUp'):
                self.send('Input.dispatchKeyEvent', type=kind, key=c, text=c if kind == 'keyDown' else '')

    def choose(self, *paths):
        """The files that the next dialog is answered with, once it is open."""
        until = time.monotonic() + 30
        while not (asked := [p for what, p in self.events if what == 'Page.fileChooserOpened']):
            assert time.monotonic() < until, 'no dialog of files was opened'
            self.evaluate('0')
        self.events = [e for e in self.events if e[0] != 'Page.fileChooserOpened']
        self.send('DOM.setFileInputFiles', files=list(paths), backendNodeId=asked[-1]['backendNodeId'])

    def drop(self, x, y, *paths):
        for kind in ('dragEnter', 'dragOver', 'drop'):
            self.send('Input.dispatchDragEvent', type=kind, x=x, y=y, data={'items': [], 'files': list(paths), 'dragOperationsMask': 1})


@contextlib.contextmanager
def served(folder):
    """The folder by a plain file server; yields its port."""
    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *_):
            pass
    server = http.server.ThreadingHTTPServer(('127.0.0.1', 0), functools.partial(Quiet, directory=folder))
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield server.server_address[1]
    finally:
        server.shutdown()
        thread.join()
