#!/usr/bin/env python3
"""The page in a real browser (Debian's chromium, without a window, with its software renderer):

    tests/web/page_test.py build-web/site build/gelenk [--pictures FOLDER] [NAME...]

runs every check, or those whose name contains one of the words. The page is served from a sub-folder; nothing but the browser's
own notes may stand in its console."""
import argparse
import collections
import gzip
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import time
import traceback
import zipfile

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from browser import Browser, served  # noqa: E402

root = os.path.abspath(os.path.join(os.path.dirname(__file__), '..', '..'))
options = argparse.ArgumentParser()
options.add_argument('site')
options.add_argument('native')
options.add_argument('names', nargs='*')
options.add_argument('--pictures')
options = options.parse_intermixed_args()
native = os.path.abspath(options.native)


class Page:
    """The page in the browser, and what a person does with it."""

    def __init__(self, browser, port):
        self.browser, self.address = browser, f'http://127.0.0.1:{port}/lectures/site/'

    def open(self, query='', width=1280, height=800, ratio=1):
        self.browser.console.clear()
        self.browser.size(width, height, ratio)
        self.ratio = ratio
        self.browser.open(self.address + query)
        self.browser.wait('window.gelenk?.ready')

    def status(self):
        return self.browser.evaluate('gelenk.status()')

    def ask(self, **request):
        reply = self.browser.evaluate(f'gelenk.ask({json.dumps(request)})')
        assert reply['ok'], reply
        return reply

    def frames(self, n=2):
        """Until so many more frames were drawn, or the page rests."""
        self.browser.wait(f'gelenk.resting || gelenk.frames >= {self.browser.evaluate("gelenk.frames") + n}')

    def goal(self, name):
        return next(g for g in self.status()['goals'] if g['name'] == name)

    def pixel(self, name):
        return [v / self.ratio for v in self.goal(name)['pixel']]

    def rest(self):
        """Until nothing is drawn any more: the still picture is refined, a moving camera has arrived."""
        self.browser.wait('(async () => { const n = gelenk.frames; await new Promise((go) => setTimeout(go, 700)); return gelenk.frames === n; })()', 240)

    def press(self, name, **modifiers):
        """A key of the keyboard by its name; letters and digits as on an English one."""
        code, number = keys[name] if name in keys else (('Digit' if name.isdigit() else 'Key') + name.upper(), ord(name.upper()))
        self.browser.key(name.upper() if modifiers.get('shift') else name, code, number, **modifiers)
        self.frames()

    def act(self, words):
        """By the palette, as from the keyboard: Ctrl+K, the words, Enter."""
        self.press('k', control=True)
        self.browser.type(words)
        self.frames(3)
        self.press('Enter')
        self.frames(3)

    def downloaded(self, ending, seconds=20):
        """The one file so named that came down, whole."""
        until = time.monotonic() + seconds
        while True:
            found = [f for f in os.listdir(self.browser.downloads) if f.endswith(ending)] if os.path.isdir(self.browser.downloads) else []
            if found:
                return os.path.join(self.browser.downloads, found[0])
            assert time.monotonic() < until, (ending, self.notices())
            time.sleep(0.1)

    def notices(self):
        return self.browser.evaluate('gelenk.notices()')

    def picture(self, name):
        if options.pictures:
            os.makedirs(options.pictures, exist_ok=True)
            self.browser.picture(os.path.join(options.pictures, name + '.png'))


keys = {'Tab': ('Tab', 9), 'Enter': ('Enter', 13), 'Escape': ('Escape', 27), ' ': ('Space', 32), 'Home': ('Home', 36),
        'Delete': ('Delete', 46), '/': ('Slash', 191), '[': ('BracketLeft', 219), ']': ('BracketRight', 221)}
checks = []


def check(function):
    checks.append(function)
    return function


def output(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, (command, done.returncode, done.stderr)
    return done.stdout


# ---- what a person sees and does

@check
def the_figure_stands_and_its_left_hand_follows_the_mouse(page):
    page.open()
    browser = page.browser
    first = browser.evaluate('gelenk.firstFrame')
    print(f'    first frame {first / 1000:.1f} s after the page was asked for, renderer {page.status()["renderer"]}')
    page.frames(4)
    page.picture('figure')
    hand = 'hand_l'
    x, y = page.pixel(hand)
    before = page.goal(hand)['reached']
    browser.mouse('mouseMoved', x, y, 'none')
    page.frames()
    browser.mouse('mousePressed', x, y)
    for i in range(1, 9):
        browser.mouse('mouseMoved', x - 6 * i, y - 9 * i, held=True)
        page.frames(1)
    page.frames(3)
    assert page.status()['dragging'] == hand, page.status()['dragging']
    page.picture('drag')
    during = page.goal(hand)
    browser.mouse('mouseReleased', x - 48, y - 72)
    page.frames(4)
    after = page.goal(hand)
    moved = math.dist(before, after['reached'])
    print(f'    {hand} went {100 * moved:.1f} cm, error {1e6 * during["error"]:.2f} um')
    assert moved > 0.1 and during['error'] < 1e-3 and after['error'] < 1e-3
    assert math.dist(page.pixel(hand), (x - 48, y - 72)) < 1.5, (page.pixel(hand), x, y)


@check
def every_key_does_in_the_page_what_the_help_says(page):
    page.open()
    browser = page.browser
    browser.evaluate('document.getElementById("canvas").focus()')
    hand, rest_pose = 'hand_l', page.status()['q']

    def same(a, b):
        return math.dist(a, b) < 1e-12  # quaternions are made of length one again

    def view():
        page.rest()
        return [v for name in ('head', 'hand_l', 'foot_r') for v in page.pixel(name)]

    def shows(name, *, differs, **modifiers):
        """The key changes the view, or the picture where the pixels of goals tell nothing of it."""
        before = differs()
        page.press(name, **modifiers)
        after = differs()
        assert before != after, (name, before if isinstance(before, list) else 'the same picture')
        return before, after

    def picture():
        page.rest()
        return browser.send('Page.captureScreenshot', format='png')['data']

    for name in ('3', '7', '1', '5', '5'):
        shows(name, differs=view)
    browser.mouse('mouseMoved', 300, 300, 'none')
    browser.send('Input.dispatchMouseEvent', type='mouseWheel', x=300, y=300, deltaX=0, deltaY=-300)
    page.frames()
    shows('Home', differs=view)
    browser.mouse('mouseMoved', *page.pixel(hand), 'none')
    page.frames()
    page.press('p')
    assert page.goal(hand)['state'] == 'pinned', page.goal(hand)
    page.press('p')
    assert page.goal(hand)['state'] == 'free', page.goal(hand)
    # A drag, locked to an axis; undone and done again; mirrored; the rest pose.
    before = page.status()['q']
    x, y = page.pixel(hand)
    browser.mouse('mousePressed', x, y)
    page.frames()
    browser.mouse('mouseMoved', x - 10, y - 20, held=True)
    page.frames(3)
    target = page.goal(hand)['target']
    page.press('y')
    browser.mouse('mouseMoved', x - 40, y - 60, held=True)
    page.frames(4)
    locked = page.goal(hand)['target']
    browser.mouse('mouseReleased', x - 40, y - 60)
    page.rest()
    assert abs(locked[1] - target[1]) > 0.05 and max(abs(locked[i] - target[i]) for i in (0, 2)) < 1e-9, (target, locked)
    posed = page.status()['q']
    page.press('z', control=True)
    assert same(page.status()['q'], before), page.status()['q']
    # What is done again settles anew from where it was recorded, in steps of 1e-6.
    page.press('z', control=True, shift=True)
    assert math.dist(page.status()['q'], posed) < 1e-4, (page.status()['q'], posed)
    page.press('z', control=True)
    page.press('y', control=True)
    assert math.dist(page.status()['q'], posed) < 1e-4, (page.status()['q'], posed)
    page.press('m')
    page.rest()
    assert not same(page.status()['q'], posed) and not same(page.status()['q'], rest_pose)
    page.press('r')
    page.rest()
    assert same(page.status()['q'], rest_pose), page.status()['q']
    first = page.status()['solver']
    page.press('Tab')
    second = page.status()['solver']
    page.press('Tab', shift=True)
    assert second != first == page.status()['solver'], (first, second)
    for name, modifiers in (('h', {}), ('Escape', {}), ('/', {'shift': True}), ('Escape', {}), ('l', {}), ('l', {})):
        shows(name, differs=picture, **modifiers)
    # The same keys where the layout writes other signs: ? of a German keyboard, Ctrl+Z of a Russian one.
    before = picture()
    browser.key('?', 'Minus', 189, shift=True)
    assert picture() != before, 'the help did not open'
    page.press('Escape')
    page.press('m')
    page.rest()
    browser.key('\u044f', 'KeyZ', 90, control=True)
    page.rest()
    assert same(page.status()['q'], rest_pose), page.status()['q']
    # Goals go by Delete.
    page.open('?model=planar')
    name = page.status()['goals'][-1]['name']
    page.ask(do='set', goals=[{'name': name, 'target': page.goal(name)['reached'], 'state': 'pinned'}])
    page.rest()
    browser.mouse('mouseMoved', *page.pixel(name), 'none')
    page.frames()
    browser.evaluate('document.getElementById("canvas").focus()')
    page.press('Delete')
    assert not any(g['name'] == name and g['state'] == 'pinned' for g in page.status()['goals']), page.status()['goals']
    # The browser's own keys stay its own: F5, F12, Ctrl+R, Alt+Left.
    browser.evaluate("window.kept = []; addEventListener('keydown', (e) => kept.push([e.key, e.defaultPrevented]))")
    for name, code, number, modifiers in (('F5', 'F5', 116, {}), ('r', 'KeyR', 82, {'control': True}), ('ArrowLeft', 'ArrowLeft', 37, {'alt': True}),
                                          ('z', 'KeyZ', 90, {'control': True})):
        browser.key(name, code, number, kinds=('rawKeyDown',) if name != 'z' else ('rawKeyDown', 'keyUp'), **modifiers)
    kept = browser.evaluate('kept')
    assert kept == [['F5', False], ['r', False], ['ArrowLeft', False], ['z', True]], kept


@check
def files_dropped_together_open_as_one(page):
    page.open()
    folder = tempfile.mkdtemp(prefix='gelenk-drop-')
    try:
        inputs = os.path.join(root, 'tests', 'data')
        output(native, 'convert', os.path.join(inputs, 'tube.obj'), '--skeleton', os.path.join(inputs, 'tube.skel'),
               os.path.join(folder, 'tube.glb'))
        with zipfile.ZipFile(os.path.join(folder, 'arms.zip'), 'w', zipfile.ZIP_DEFLATED) as packed:
            packed.write(os.path.join(inputs, 'two_arms.urdf'), 'arms/two_arms.urdf')
            packed.writestr('arms/readme.txt', 'two arms ' * 100)
            packed.writestr('__MACOSX/arms/._two_arms.urdf', b'\0\5\x16\7')  # as macOS packs it
        for name, files in {'tube': ['tube.glb'], 'twoarms': ['arms.zip']}.items():
            page.browser.drop(400, 400, *[os.path.join(folder, f) for f in files])
            page.browser.wait(f'gelenk.status().model.includes("{name}")')
            assert not any(n['error'] for n in page.notices()), page.notices()
        page.browser.drop(400, 400, *[os.path.join(inputs, f) for f in ('tube.obj', 'tube.skel')])
        page.browser.wait('gelenk.status().model.includes("tube")')
        page.browser.drop(400, 400, *[os.path.join(inputs, f) for f in ('straight.urdf', 'two_arms.urdf')])
        page.browser.wait('gelenk.notices().some((n) => n.error && n.words.includes("straight.urdf, two_arms.urdf"))')
        page.browser.drop(400, 400, os.path.join(root, 'LICENSE'))
        page.browser.wait('gelenk.notices().some((n) => n.error && n.words.includes("LICENSE"))')
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@check
def every_example_of_the_lecture_runs(page):
    topics = [line.split()[0] for line in output(native, 'lecture', '--list').splitlines() if line[:1].isalpha()]
    assert len(topics) >= 9, topics
    page.open('?lecture=newton')
    assert page.status()['example'] == 'newton-1d', page.status()['example']
    page.open(f'?lecture={topics[0]}')
    assert page.status()['example'] == topics[0], page.status()['example']
    for topic in topics:
        page.ask(do='open', file=f'lecture:{topic}')
        page.frames(6)
        status = page.status()
        assert status['example'] == topic, (topic, status['example'])
        assert all(math.isfinite(v) for v in status['q']), (topic, status['q'])
        assert not any(n['error'] for n in page.notices()), page.notices()
        page.picture('lecture-' + topic)
    print(f'    {len(topics)} examples')


@check
def models_and_themes_are_named_in_the_address(page):
    page.open('?model=panda&theme=dark&solver=dls')
    status = page.status()
    assert status['model'] == 'panda' and status['solver'] == 'dls', status
    page.frames(4)
    page.picture('panda-dark')
    page.open('?model=nonsense')
    assert page.status()['model'] == 'figure'
    assert any(n['error'] and 'nonsense' in n['words'] for n in page.notices()), page.notices()
    page.open('?panel=off')
    view = page.status()['view']
    assert (view['width'], view['height']) == (1280, 800), view


@check
def a_link_holds_the_scene(page):
    page.open('?model=panda')
    q = [0.3, -0.8, 0.1, -2.0, 0.2, 1.6, 0.8]
    page.ask(do='set', q=q)
    page.frames()
    word = page.browser.evaluate('gelenk.link()')
    print(f'    a link of {len(word)} characters')
    page.open(f'#scene={word}')
    assert page.status()['model'] == 'panda' and page.status()['q'] == q, page.status()['q']
    # A description that stands in no file is held as well, an example of the lecture with where it stands.
    page.open('?model=planar:0,0:1,1,0.5')
    page.ask(do='set', q=[0.3, 0.4, 0.5])
    page.open(f'#scene={page.browser.evaluate("gelenk.link()")}')
    assert page.status()['q'] == [0.3, 0.4, 0.5], page.status()['q']
    page.open('?lecture=two-link')
    before = page.status()
    page.open(f'#scene={page.browser.evaluate("gelenk.link()")}')
    after = page.status()
    assert after['example'] == before['example'] != '' and after['q'] == before['q'], (before, after)
    page.open('#scene=nonsense')
    assert page.status()['model'] == 'figure'
    assert any(n['error'] and 'link' in n['words'] for n in page.notices()), page.notices()


@check
def saving_downloads_and_the_scene_stays_in_the_browser(page):
    page.open('?model=planar')
    page.browser.evaluate('document.getElementById("canvas").focus()')
    page.browser.key('s', 'KeyS', 83, control=True)
    page.frames(4)
    page.browser.key('a', 'KeyA', 65, control=True)
    page.browser.type('mi')
    page.browser.evaluate("""for (const kind of ['keydown', 'keyup']) document.getElementById('canvas').dispatchEvent(new KeyboardEvent(kind,
      { key: '@', code: 'KeyQ', ctrlKey: true, altKey: true, modifierAltGraph: true, cancelable: true }))""")  # AltGr+Q of a German keyboard
    page.browser.type('ne')
    page.frames(3)
    page.browser.key('Enter', 'Enter', 13)
    path = os.path.join(page.browser.downloads, 'mi@ne.json')
    until = time.monotonic() + 20
    while not os.path.exists(path):
        assert time.monotonic() < until, (page.notices(), os.listdir(page.browser.downloads) if os.path.isdir(page.browser.downloads) else None)
        time.sleep(0.1)
    with open(path) as file:
        assert json.load(file)['model'], path
    output(native, 'info', path)
    page.browser.wait('gelenk.kept()')
    page.open()
    page.ask(do='open', file='/home/gelenk/mi@ne.json')
    assert page.status()['model'] == 'planar'


@check
def files_come_by_the_dialog_and_folders_by_drop(page):
    page.open()
    browser, inputs = page.browser, os.path.join(root, 'tests', 'data')
    browser.send('Page.setInterceptFileChooserDialog', enabled=True)
    browser.evaluate('document.getElementById("canvas").focus()')
    page.press('o', control=True)
    browser.choose(*[os.path.join(inputs, f) for f in ('tube.obj', 'tube.skel')])
    browser.wait('gelenk.status().model.includes("tube")')
    page.act('open a file')
    browser.choose(os.path.join(inputs, 'standing_z.bvh'))
    browser.wait('gelenk.status().panels?.Motion')
    folder = tempfile.mkdtemp(prefix='gelenk-folder-')
    try:
        robot = os.path.join(folder, 'two')
        os.makedirs(os.path.join(robot, 'meshes'))
        shutil.copy(os.path.join(inputs, 'two_arms.urdf'), robot)
        browser.drop(400, 400, robot)
        browser.wait('gelenk.status().model.includes("twoarms")')
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    assert not any(n['error'] for n in page.notices()), page.notices()


@check
def every_tab_and_every_picture_is_drawn(page):
    browser = page.browser

    def picture():
        page.frames(3)
        return browser.send('Page.captureScreenshot', format='png')['data']

    for query, tabs in (('', ('Solve', 'Model', 'Skin', 'Binding', 'Muscles', 'Motion', 'Pictures', 'Path', 'Lab', 'Lecture')),
                        ('?model=panda', ('Solve', 'Model', 'Skin', 'Pictures', 'Path', 'Lab')),
                        ('?lecture=newton', ('Lecture', 'Solve', 'Model'))):
        page.open(query)
        browser.evaluate('document.getElementById("canvas").focus()')
        seen = set()
        for tab in tabs:
            page.act(f'tab {tab}')
            seen.add(picture())
            page.picture(f'tab-{query.strip("?") or "figure"}-{tab}')
        assert len(seen) == len(tabs), (query, len(seen), tabs)
        for option in ('wireframe', 'skeleton', 'weights', 'joint_frames', 'velocity_ellipsoid', 'reachable'):
            before = option in page.status()['shown']
            page.act('show or hide ' + option.replace('_', ' '))
            assert (option in page.status()['shown']) != before, (query, option, page.status()['shown'])
            page.act('show or hide ' + option.replace('_', ' '))
        assert not any(n['error'] for n in page.notices()), (query, page.notices())


@check
def screenshots_and_links_come_from_the_menus(page):
    page.open('?model=panda')
    browser = page.browser
    browser.evaluate('document.getElementById("canvas").focus()')
    page.act('screenshot')
    with open(page.downloaded('.png'), 'rb') as file:
        head = file.read(24)
    assert head[:8] == b'\x89PNG\r\n\x1a\n' and (int.from_bytes(head[16:20]), int.from_bytes(head[20:24])) == (1280, 800), head
    page.act('link to this scene')
    browser.wait('location.hash.startsWith("#scene=")')
    page.act('record a film')
    assert any('ffmpeg' in n['words'] for n in page.notices()), page.notices()
    # A link that is followed while the page is open.
    q = [0.3, -0.8, 0.1, -2.0, 0.2, 1.6, 0.8]
    page.ask(do='set', q=q)
    word = browser.evaluate('gelenk.link()')
    page.ask(do='open', file='planar')
    browser.evaluate(f'location.hash = "#scene={word}"')
    browser.wait('gelenk.status().model === "panda"')
    assert page.status()['q'] == q, page.status()['q']


@check
def size_and_pixel_ratio_are_followed(page):
    page.open('', 1000, 700, 1)
    narrow = page.status()['view']
    page.browser.size(1400, 900, 1)
    page.browser.wait(f'gelenk.status().view.height > {narrow["height"]} + 80')
    assert page.browser.evaluate('document.getElementById("canvas").width') == 1400
    page.open('', 1000, 700, 2)
    fine = page.status()['view']
    assert abs(fine['width'] - 2 * narrow['width']) <= 2 and abs(fine['height'] - 2 * narrow['height']) <= 4, (fine, narrow)
    page.frames(4)
    page.picture('figure-at-two')


@check
def one_finger_drags_and_two_orbit_and_zoom(page):
    page.open('', 420, 760, 2)
    page.frames(4)
    page.picture('telephone')
    x, y = page.pixel('hand_l')
    browser = page.browser
    browser.touch('touchStart', (x, y))
    for i in range(1, 7):
        browser.touch('touchMove', (x - 3 * i, y - 8 * i))
        page.frames(1)
    page.frames(3)
    during = page.goal('hand_l')
    browser.touch('touchEnd')
    page.frames(3)
    assert during['state'] == 'dragged' and during['error'] < 1e-3, during
    assert math.dist(page.pixel('hand_l'), (x - 18, y - 48)) < 2, (page.pixel('hand_l'), x, y)
    browser.wait('gelenk.resting')  # the pose has settled
    q = page.status()['q']
    head, foot = page.pixel('head'), page.pixel('foot_l')
    browser.touch('touchStart', (150, 500))
    browser.touch('touchStart', (150, 500), (250, 500))
    page.frames(2)
    for i in range(1, 7):
        browser.touch('touchMove', (150 - 8 * i, 500), (250 + 8 * i, 500))
        page.frames(1)
    browser.touch('touchEnd')
    page.frames(3)
    grown = math.dist(page.pixel('head'), page.pixel('foot_l')) / math.dist(head, foot)
    assert grown > 1.2, grown
    assert page.status()['q'] == q


@check
def two_fingers_scroll_a_panel(page):
    page.open('', 1000, 420)
    browser = page.browser
    before = page.status()
    page.rest()
    x = before['view']['width'] + 150  # the panels' column

    def column():
        return browser.send('Page.captureScreenshot', format='png', clip={'x': x - 100, 'y': 60, 'width': 200, 'height': 300, 'scale': 1})['data']

    seen = column()
    browser.touch('touchStart', (x, 320))
    browser.touch('touchStart', (x, 320), (x + 60, 320))
    page.frames(2)
    for i in range(1, 6):
        browser.touch('touchMove', (x, 320 - 40 * i), (x + 60, 320 - 40 * i))
        page.frames(1)
    browser.touch('touchEnd')
    page.rest()
    assert column() != seen, 'the panel did not move'
    page.picture('panel-scrolled')
    assert page.status()['q'] == before['q'] and page.pixel('head') == [v for v in next(g for g in before['goals'] if g['name'] == 'head')['pixel']]


@check
def a_page_drives_the_sandbox_in_its_frame(page):
    frame = page.address + '?model=panda&panel=off'
    outside = page.address.replace('127.0.0.1', 'localhost').replace('/site/', '/')
    browser = page.browser
    script = """
      new Promise((done) => {
        const log = [], frame = document.createElement('iframe');
        const ask = (m) => frame.contentWindow.postMessage({ gelenk: 1, ...m }, 'http://127.0.0.1:%d');
        addEventListener('message', (e) => {
          log.push(e.data);
          if (e.data.event === 'ready') { ask({ id: 1, do: 'events' }); ask({ id: 2, do: 'set', q: [0, -0.8, 0, -2.4, 0, 1.6, 0.8] }); ask({ id: 3, do: 'nonsense' }); }
          if (log.some((m) => m.id === 3) && log.some((m) => m.event === 'pose')) done(log);
        });
        setTimeout(() => done(log), %d);
        frame.width = 900; frame.height = 600; frame.src = '%s';
        document.body.append(frame);
        frame.addEventListener('load', () => setTimeout(() => ask({ id: 9, do: 'get' }), 3000));
      })"""
    port = int(page.address.split(':')[2].split('/')[0])
    browser.console.clear()
    browser.size(1000, 700)
    browser.open(outside + 'outside.html')
    browser.wait('!!document.body')
    log = browser.evaluate(script % (port, 60000, frame + '&embed=' + outside.rsplit('/lectures', 1)[0]))
    answers = {m['id']: m for m in log if m.get('id')}
    assert answers[2]['ok'] and not answers[3]['ok'] and 'nonsense' in answers[3]['error'], log
    pose = next(m for m in log if m.get('event') == 'pose')
    assert pose['model'] == 'panda' and pose['q'] == [0, -0.8, 0, -2.4, 0, 1.6, 0.8], pose
    page.picture('embedded')
    browser.open(outside + 'outside.html')
    browser.wait('!!document.body')
    log = browser.evaluate(script % (port, 15000, frame))  # an origin that the address does not name
    assert log == [], log


@check
def without_webgl_a_sentence_says_so(page):
    with Browser('--disable-3d-apis') as browser:
        browser.open(page.address)
        browser.wait('document.getElementById("cover")?.classList.contains("failed")')
        words = browser.evaluate('document.getElementById("sentence").textContent')
        assert 'WebGL 2' in words, words


@check
def the_shader_agrees_with_the_reference_in_double_precision(page):
    page.open()
    page.ask(do='set', goals=[{'name': 'hand_l', 'target': [0.3, 1.6, 0.3], 'state': 'held'},
                              {'name': 'foot_r', 'target': [-0.2, 0.4, 0.4], 'state': 'held'}])
    page.frames(8)
    for choice in ('lbs', 'dqs+twist', 'cor+twist+smooth'):
        found = page.browser.evaluate(f'gelenk.shaderError("{choice}")')
        print(f'    {choice}: {found}')
        # The tolerances of the native test, tests/gpu/skin_methods_gl_test.cpp.
        assert found['vertices'] > 30000 and 0 < found['position'] < 1e-5 and found['normal'] < 2e-3, found


@check
def the_download_stays_small(page):
    total = 0
    for name in ('gelenk.wasm', 'gelenk.js', 'gelenk.data', 'index.html', 'page.js', 'page.css'):
        with open(os.path.join(options.site, name), 'rb') as file:
            whole = file.read()
        packed = len(gzip.compress(whole, 9))
        total += packed
        print(f'    {name}: {len(whole) / 1000:.0f} kB, gzip -9 {packed / 1000:.0f} kB')
    print(f'    together {total / 1e6:.2f} MB compressed')


# ---- all of them

def told(console):
    """Every line once, with how often it came."""
    return [f'{n} x {line}' for line, n in collections.Counter(console).items()]


def main():
    folder = tempfile.mkdtemp(prefix='gelenk-page-')
    wanted = [c for c in checks if not options.names or any(n in c.__name__ for n in options.names)]
    failed = 0
    try:
        shutil.copytree(options.site, os.path.join(folder, 'lectures', 'site'))
        with open(os.path.join(folder, 'lectures', 'outside.html'), 'w') as file:
            file.write('<!doctype html><link rel="icon" href="data:,"><body></body>')
        with served(folder) as port:
            for each in wanted:
                begin = time.monotonic()
                print(each.__name__.replace('_', ' '), flush=True)
                console = []
                try:
                    with Browser() as browser:  # its own: one that ends takes no other check with it
                        console = browser.console
                        each(Page(browser, port))
                        assert not console, told(console)
                    print(f'    ok, {time.monotonic() - begin:.1f} s', flush=True)
                except Exception:
                    failed += 1
                    traceback.print_exc()
                    print(f'    FAILED; console: {told(console)}', flush=True)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    print(f'{len(wanted) - failed} of {len(wanted)} checks hold')
    sys.exit(failed > 0)


if __name__ == '__main__':
    main()
