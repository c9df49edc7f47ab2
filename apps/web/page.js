// The page around the sandbox: loads it, hands it the browser's input, files and size, and calls it for frames (docs/web.md).
'use strict';
(() => {
  const canvas = document.getElementById('canvas');
  const cover = document.getElementById('cover');
  const address = new URLSearchParams(location.search);
  const bytes = Number(document.currentScript.dataset.bytes) || 6e6;  // of gelenk.wasm and gelenk.data
  const home = '/home/gelenk', openedFolder = '/opened';
  let module = null;   // once it runs
  let frames = 0, firstFrame = 0;
  let atFirst = '';    // what was wrong with the address

  if (address.get('theme') === 'dark') document.documentElement.classList.add('dark');

  function fail(sentence) {
    cover.hidden = false;
    cover.classList.add('failed');
    document.getElementById('sentence').textContent = sentence;
  }

  // ---- loading

  let received = 0;
  function progress(n) {
    received += n;
    document.getElementById('done').style.width = `${Math.min(100, 100 * received / bytes)}%`;
  }

  /// A response whose bytes move the bar.
  async function fetched(name, type) {
    const response = await fetch(name);
    if (!response.ok) throw new Error(`${name}: ${response.status} ${response.statusText}`);
    const reader = response.body.getReader();
    return new Response(new ReadableStream({
      async pull(controller) {
        const { done, value } = await reader.read();
        if (done) return controller.close();
        progress(value.length);
        controller.enqueue(value);
      }
    }), { headers: { 'Content-Type': type } });
  }

  async function load() {
    const data = fetched('gelenk.data', 'application/octet-stream').then((r) => r.arrayBuffer());
    const code = WebAssembly.compileStreaming(fetched('gelenk.wasm', 'application/wasm'));
    const [packed, compiled] = await Promise.all([data, code]);
    return Gelenk({
      canvas,
      getPreloadedPackage: () => packed,
      instantiateWasm(imports, use) {
        WebAssembly.instantiate(compiled, imports).then((instance) => use(instance, compiled));
        return {};
      },
      preRun: [(m) => {
        m.ENV.HOME = home;
        m.ENV.XDG_CACHE_HOME = '/cache';
        for (const folder of [home, openedFolder]) m.FS.mkdirTree(folder);
        m.FS.mount(m.IDBFS, {}, home);
        m.addRunDependency('kept');
        m.FS.syncfs(true, () => m.removeRunDependency('kept'));  // without a data base nothing is kept
        m.FS.chdir(home);
      }],
      chooseFiles: () => document.getElementById('files').click(),
      shareScene,
      copy,
      print: (text) => console.info(text),
      printErr: (text) => console.warn(text)
    });
  }

  // ---- texts between the page and the program

  const call = (name, result, types, values) => module.ccall(name, result, types, values);
  const ask = (request) => JSON.parse(call('page_ask', 'string', ['string'], [JSON.stringify(request)]));
  const say = (sentence, isError = false) => {
    call('page_say', null, ['string', 'number'], [sentence, isError ? 1 : 0]);
    wake();
  };

  // ---- size

  const ratio = () => window.devicePixelRatio || 1;
  const scale = () => Math.max(1, Math.round(4 * ratio()) / 4);
  function size() {
    return { width: Math.max(1, Math.round(canvas.clientWidth * ratio())),
             height: Math.max(1, Math.round(canvas.clientHeight * ratio())) };
  }
  new ResizeObserver(() => wake()).observe(canvas);
  (function followRatio() {
    matchMedia(`(resolution: ${ratio()}dppx)`).addEventListener('change', () => { followRatio(); wake(); }, { once: true });
  })();

  // ---- frames

  let asked = 0, timer = 0, last = 0;
  /// Something happened: the next frame is drawn.
  function wake() {
    if (!module || asked) return;
    clearTimeout(timer);
    asked = requestAnimationFrame(frame);
  }

  function frame(now) {
    asked = 0;
    const { width, height } = size();
    if (canvas.width !== width) canvas.width = width;
    if (canvas.height !== height) canvas.height = height;
    let rests = -2;
    try {
      rests = module._page_frame(width, height, scale(), last ? Math.max(0, (now - last) / 1000) : 1 / 60);
    } catch (error) {
      console.error(error);
    }
    if (rests === -2) {
      module = null;
      return fail('The sandbox has stopped; load the page again.');
    }
    last = now;
    if (++frames === 1) {
      firstFrame = performance.now();
      cover.hidden = true;
      if (window.parent === window) canvas.focus();
      last = performance.now();  // what was made for the first frame is no time of the scene
      tell({ event: 'ready' });
      if (atFirst) say(atFirst, true);
    }
    offerSaved();
    tellPose();
    if (rests === 0) wake();
    else if (rests > 0) timer = setTimeout(wake, 1000 * rests);
  }

  // ---- mouse and fingers

  const LEFT = 0, RIGHT = 1, MIDDLE = 2;  // as GLFW counts
  const buttons = [LEFT, MIDDLE, RIGHT];  // as the browser counts
  const pixelAt = (x, y) => {
    const box = canvas.getBoundingClientRect();
    return [(x - box.left) * ratio(), (y - box.top) * ratio()];
  };
  const place = (x, y) => module._page_move(...pixelAt(x, y));
  function button(which, down) {
    module._page_button(which, down ? 1 : 0);
    wake();
  }

  const fingers = new Map();
  let gesture = null;  // 'drag': one finger, the left button; 'two' in the view: the middle button and the wheel; 'scroll' in a panel
  let spread = 0, height = 0;
  const scrollStep = 80;  // by which a panel moves with a step of the wheel
  const middle = () => {
    const all = [...fingers.values()];
    return { x: all.reduce((s, f) => s + f.x, 0) / all.length, y: all.reduce((s, f) => s + f.y, 0) / all.length };
  };
  const distance = () => {
    const [a, b] = [...fingers.values()];
    return Math.hypot(a.x - b.x, a.y - b.y);
  };

  function fingerDown(event) {
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (fingers.size === 1) {
      gesture = 'drag';
      place(event.clientX, event.clientY);
      button(LEFT, true);
    } else if (fingers.size === 2) {
      if (gesture === 'drag') button(LEFT, false);
      spread = distance();
      height = middle().y;
      gesture = module._page_in_view(...pixelAt(middle().x, middle().y)) ? 'two' : 'scroll';
      place(middle().x, middle().y);
      if (gesture === 'two') button(MIDDLE, true);
    }
  }
  function fingerMoves(event) {
    if (!fingers.has(event.pointerId)) return;
    fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (gesture === 'drag') place(event.clientX, event.clientY);
    if (gesture === 'two' && fingers.size === 2) {
      place(middle().x, middle().y);
      const now = distance();
      if (now > 1 && spread > 1) module._page_wheel(0, Math.log(now / spread) / -Math.log(0.9));
      spread = now;
    }
    if (gesture === 'scroll' && fingers.size === 2) {
      module._page_wheel(0, (middle().y - height) / scrollStep);
      height = middle().y;
    }
    wake();
  }
  function fingerUp(event) {
    if (!fingers.delete(event.pointerId)) return;
    if (gesture === 'drag') button(LEFT, false);
    if (gesture === 'two') button(MIDDLE, false);
    gesture = null;
    if (fingers.size === 0) module._page_move(-1, -1);  // nothing lies under a finger that is gone
    wake();
  }

  canvas.addEventListener('pointerdown', (event) => {
    if (!module) return;
    canvas.focus();
    modifiers(event);
    canvas.setPointerCapture(event.pointerId);
    if (event.pointerType === 'touch') return fingerDown(event);
    place(event.clientX, event.clientY);
    if (event.button < 3) button(buttons[event.button], true);
  });
  canvas.addEventListener('pointermove', (event) => {
    if (!module) return;
    if (event.pointerType === 'touch') return fingerMoves(event);
    for (const each of event.getCoalescedEvents?.().slice(-1) ?? [event]) place(each.clientX, each.clientY);
    // A second button of a mouse that is held tells of itself by a move.
    if (event.button >= 0 && event.button < 3) button(buttons[event.button], (event.buttons & [1, 4, 2][event.button]) !== 0);
    wake();
  });
  for (const name of ['pointerup', 'pointercancel'])
    canvas.addEventListener(name, (event) => {
      if (!module) return;
      if (event.pointerType === 'touch') return fingerUp(event);
      place(event.clientX, event.clientY);
      if (name === 'pointercancel') [LEFT, RIGHT, MIDDLE].forEach((b) => button(b, false));
      else if (event.button < 3) button(buttons[event.button], false);
    });
  canvas.addEventListener('pointerleave', (event) => {
    if (module && event.pointerType !== 'touch' && event.buttons === 0) { module._page_move(-1, -1); wake(); }
  });
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    if (!module) return;
    const step = event.deltaMode === 0 ? 100 : event.deltaMode === 1 ? 3 : 1;  // pixels, lines, pages
    module._page_wheel(-event.deltaX / step, -event.deltaY / step);
    wake();
  }, { passive: false });

  // ---- keys, as GLFW numbers them; letters and brackets by what is written on the key, the rest by its place

  const named = { Space: 32, Quote: 39, Comma: 44, Minus: 45, Period: 46, Slash: 47, Semicolon: 59, Equal: 61, BracketLeft: 91, Backslash: 92,
    BracketRight: 93, Backquote: 96, Escape: 256, Enter: 257, Tab: 258, Backspace: 259, Insert: 260, Delete: 261, ArrowRight: 262,
    ArrowLeft: 263, ArrowDown: 264, ArrowUp: 265, PageUp: 266, PageDown: 267, Home: 268, End: 269, NumpadDecimal: 330, NumpadDivide: 331,
    NumpadMultiply: 332, NumpadSubtract: 333, NumpadAdd: 334, NumpadEnter: 335 };
  const signs = { '[': 91, ']': 93, '/': 47, '?': 47 };
  function placeCode(event) {
    if (event.code in named) return named[event.code];
    const [, kind, sign] = /^(Key|Digit|Numpad)([A-Z0-9])$/.exec(event.code) ?? [];
    if (!kind) return -1;  // function keys belong to the browser
    return kind === 'Numpad' ? 320 + Number(sign) : sign.charCodeAt(0);
  }
  function keyCode(event) {
    if (/^[a-z]$/i.test(event.key)) return event.key.toUpperCase().charCodeAt(0);
    return signs[event.key] ?? placeCode(event);
  }
  /// Control and Alt for themselves: where a layout has its third signs (AltGr) they are part of the sign.
  const commands = (event) => event.getModifierState('AltGraph') ? { control: false, alt: false }
    : { control: event.ctrlKey || event.metaKey, alt: event.altKey };
  /// What the sandbox has a use for; F5, F12, Ctrl+R, Ctrl+Q, Ctrl+T, Alt+Left and the like stay the browser's.
  function isOurs(event) {
    const { control, alt } = commands(event), letter = /^Key[A-Z]$/.test(event.code) || /^[a-z]$/i.test(event.key);
    if (alt && (control || letter || event.key.length > 1)) return false;
    return !control || (letter && 'ACVXZYSOK'.includes(String.fromCharCode(keyCode(event)))) ||
      /^(Arrow.*|Home|End|Backspace|Delete|Enter)$/.test(event.key);
  }
  const held = new Set();
  function key(code, down) {
    if (down === held.has(code)) return;
    module._page_key(code, down ? 1 : 0);
    if (down) held.add(code); else held.delete(code);
  }
  /// Shift, Control and Alt as an event tells them: they may have changed while another window had the keys. Command is Control.
  function modifiers(event) {
    const { control, alt } = commands(event);
    key(340, event.shiftKey);
    key(341, control);
    key(342, alt);
    // Where Command is held, the browser tells of no key that comes up.
    if (event.key === 'Meta' && event.type === 'keyup') for (const each of [...held]) key(each, false);
  }
  canvas.addEventListener('keydown', (event) => {
    if (!module) return;
    modifiers(event);
    wake();
    if (!isOurs(event)) return;
    const code = keyCode(event), { control } = commands(event);
    if (control && code === 86) return;  // Ctrl+V: the browser says what is pasted
    if (!control && [...event.key].length === 1) module._page_character(event.key.codePointAt(0));
    else if (code < 0) return;
    event.preventDefault();
    if (code >= 0 && !event.repeat) key(code, true);
  });
  let copied = null;  // where the browser lends its clipboard to pages of https alone
  function copy(text) {
    if (navigator.clipboard) navigator.clipboard.writeText(text).catch((error) => console.info(`not copied: ${error}`));
    else copied = text;
  }
  /// Text goes into the field that is edited, files are opened.
  addEventListener('paste', async (event) => {
    if (!module) return;
    const files = [...event.clipboardData.files], text = copied ?? event.clipboardData.getData('text/plain');
    if (files.length > 0) return open(await Promise.all(files.map(async (file) => ({ path: file.name, bytes: await bytesOf(file) }))));
    for (const sign of text) module._page_character(sign.codePointAt(0));
    wake();
  });
  canvas.addEventListener('keyup', (event) => {
    if (!module) return;
    modifiers(event);
    wake();
    // What is written on a key may have changed while it was held (Shift, Alt): what is down comes up by either.
    for (const code of [keyCode(event), placeCode(event)]) if (code >= 0) key(code, false);
  });
  canvas.addEventListener('blur', () => {
    if (module) for (const code of [...held]) key(code, false);
    wake();
  });

  // ---- files: in by drop or dialog, out as downloads

  const known = new Map();  // path -> when it was last written, of files that are no news
  let drops = 0;

  /// Every file of the folders that are watched with its time of writing.
  function* written(folder) {
    const fs = module.FS;
    for (const name of fs.readdir(folder)) {
      if (name.startsWith('.')) continue;
      const path = `${folder}/${name}`;
      const { mode, mtime } = fs.stat(path);
      if (fs.isDir(mode)) yield* written(path);
      else yield [path, mtime.getTime()];
    }
  }
  const watched = () => [...written(home), ...written(openedFolder)];
  function noNews() {
    for (const [path, time] of watched()) known.set(path, time);
  }

  /// What the sandbox wrote becomes a download; scenes stay in the browser as well.
  function offerSaved() {
    let keep = false;
    for (const [path, time] of watched()) {
      if (known.get(path) === time) continue;
      known.set(path, time);
      const link = document.createElement('a');
      link.href = URL.createObjectURL(new Blob([module.FS.readFile(path)]));
      link.download = path.slice(path.lastIndexOf('/') + 1);
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 60000);
      keep = true;
      if (path.endsWith('.png')) module.FS.unlink(path);
    }
    if (keep) keepHome();
  }
  let keeping = 0;
  function keepHome() {
    ++keeping;
    module.FS.syncfs(false, (error) => {
      --keeping;
      if (error) console.info(`nothing is kept in this browser: ${error}`);
    });
  }
  addEventListener('pagehide', () => { if (module) keepHome(); });

  /// The files of a .zip: stored or deflated, by its directory at the end.
  async function unzipped(buffer) {
    const view = new DataView(buffer), text = new TextDecoder();
    let end = buffer.byteLength - 22;
    while (end >= 0 && view.getUint32(end, true) !== 0x06054b50) --end;
    if (end < 0) throw new Error('it is no .zip');
    const files = [];
    let at = view.getUint32(end + 16, true);
    for (let n = view.getUint16(end + 10, true); n > 0; --n) {
      if (view.getUint32(at, true) !== 0x02014b50) throw new Error('its directory is broken');
      const method = view.getUint16(at + 10, true), length = view.getUint32(at + 20, true);
      const nameLength = view.getUint16(at + 28, true), begin = view.getUint32(at + 42, true);
      const name = text.decode(new Uint8Array(buffer, at + 46, nameLength));
      at += 46 + nameLength + view.getUint16(at + 30, true) + view.getUint16(at + 32, true);
      if (name.endsWith('/')) continue;
      const from = begin + 30 + view.getUint16(begin + 26, true) + view.getUint16(begin + 28, true);
      const packed = new Uint8Array(buffer, from, length);
      if (method !== 0 && method !== 8) throw new Error(`${name} is packed in a way that is not read here`);
      files.push({ path: name, bytes: method === 0 ? packed : await transformed(packed, new DecompressionStream('deflate-raw')) });
    }
    return files;
  }
  async function transformed(data, stream) {
    return new Uint8Array(await new Response(new Blob([data]).stream().pipeThrough(stream)).arrayBuffer());
  }

  /// files: { path, bytes }, paths with folders as they came. Opens them as one.
  async function open(files) {
    const folder = `${openedFolder}/${++drops}`;
    const paths = [];
    try {
      const all = [];
      for (const file of files)
        if (/\.zip$/i.test(file.path))
          all.push(...await unzipped(file.bytes.buffer).catch((error) => { throw new Error(`${file.path}: ${error.message}`); }));
        else
          all.push(file);
      if (all.length === 0) return;
      for (const file of all) {
        const parts = file.path.split('/').filter((part) => part && part !== '.' && part !== '..');
        const path = [folder, ...parts].join('/');
        module.FS.mkdirTree(path.slice(0, path.lastIndexOf('/')));
        module.FS.writeFile(path, file.bytes);
        paths.push(path);
      }
      noNews();
      call('page_open', null, ['string'], [JSON.stringify(paths)]);
      noNews();
    } catch (error) {
      say(error.message, true);
    }
    wake();
  }

  const bytesOf = async (file) => new Uint8Array(await file.arrayBuffer());
  document.getElementById('files').addEventListener('change', async (event) => {
    const files = [...event.target.files];
    event.target.value = '';
    open(await Promise.all(files.map(async (file) => ({ path: file.webkitRelativePath || file.name, bytes: await bytesOf(file) }))));
  });

  /// The files of an entry, folders with all that is in them.
  async function entryFiles(entry, folder = '') {
    const path = folder + entry.name;
    if (entry.isFile) return [{ path, bytes: await bytesOf(await new Promise((take, refuse) => entry.file(take, refuse))) }];
    const reader = entry.createReader(), files = [];
    for (;;) {  // it gives a hundred at a time
      const some = await new Promise((take, refuse) => reader.readEntries(take, refuse));
      if (some.length === 0) return files;
      for (const each of some) files.push(...await entryFiles(each, `${path}/`));
    }
  }
  const shade = document.getElementById('drop');
  addEventListener('dragover', (event) => {
    event.preventDefault();
    if (module) shade.classList.add('shown');
  });
  addEventListener('dragleave', (event) => { if (!event.relatedTarget) shade.classList.remove('shown'); });
  addEventListener('drop', async (event) => {
    event.preventDefault();
    shade.classList.remove('shown');
    if (!module) return;
    const items = [...event.dataTransfer.items].filter((item) => item.kind === 'file');
    const entries = items.map((item) => item.webkitGetAsEntry?.());
    const plain = [...event.dataTransfer.files];
    try {
      const files = entries.length > 0 && entries.every(Boolean)
        ? (await Promise.all(entries.map((entry) => entryFiles(entry)))).flat()
        : await Promise.all(plain.map(async (file) => ({ path: file.name, bytes: await bytesOf(file) })));
      await open(files);
    } catch (error) {
      say(`${error.message}`, true);
    }
  });

  // ---- links: #scene= and a scene's text, deflated, in base64 of addresses

  async function packedScene(text) {
    const packed = await transformed(new TextEncoder().encode(text), new CompressionStream('deflate-raw'));
    let binary = '';
    for (const byte of packed) binary += String.fromCharCode(byte);
    return btoa(binary).replace(/\+/g, '-').replace(/\//g, '_').replace(/=+$/, '');
  }
  async function unpackedScene(word) {
    const binary = atob(word.replace(/-/g, '+').replace(/_/g, '/'));
    return new TextDecoder().decode(await transformed(Uint8Array.from(binary, (c) => c.charCodeAt(0)), new DecompressionStream('deflate-raw')));
  }
  const sceneOfAddress = () => /^#scene=(.+)$/.exec(location.hash)?.[1];

  async function shareScene() {
    const text = call('page_scene', 'string', [], []);
    if (!text) return say('A link cannot hold the files that this scene stands on: save the scene as a file', true);
    history.replaceState(null, '', `${location.pathname}#scene=${await packedScene(text)}`);
    try {
      await navigator.clipboard.writeText(location.href);
      say('The link to this scene is copied');
    } catch {
      say('The address of this page is now the link to this scene');
    }
  }
  addEventListener('hashchange', async () => {
    const word = sceneOfAddress();
    if (!module || !word) return;
    try {
      const reply = ask({ gelenk: 1, do: 'load', text: await unpackedScene(word) });
      if (!reply.ok) throw new Error(reply.error);
    } catch (error) {
      say(`The link holds no scene: ${error.message}`, true);
    }
    wake();
  });

  // ---- messages of a page that this one is a frame of

  const friends = new Set([location.origin, ...address.getAll('embed').flatMap((list) => list.split(','))]);
  let listener = null;  // who asked for events: { window, origin }
  function tell(event) {
    const parent = location.ancestorOrigins?.[0] ?? (document.referrer && new URL(document.referrer).origin);
    if (window.parent !== window && friends.has(parent)) window.parent.postMessage({ gelenk: 1, ...event }, parent);
  }
  function tellPose() {
    if (!listener) return;
    const text = call('page_event', 'string', [], []);
    if (text) listener.window.postMessage(JSON.parse(text), listener.origin);
  }
  addEventListener('message', (event) => {
    const request = event.data;
    if (!module || typeof request !== 'object' || request === null || !('gelenk' in request)) return;
    if (event.source !== window.parent || !friends.has(event.origin)) return;
    let reply;
    if (request.do === 'events' && request.gelenk === 1) {
      listener = request.on === false ? null : { window: event.source, origin: event.origin };
      reply = { gelenk: 1, id: request.id ?? null, ok: true };
    } else {
      reply = ask(request);
    }
    event.source.postMessage(reply, event.origin);
    wake();
  });

  // ---- beginning

  canvas.addEventListener('webglcontextlost', (event) => {
    event.preventDefault();
    module = null;
    fail('The browser has taken the graphics away; load the page again.');
  });

  (async () => {
    const loading = load();  // while the browser starts its graphics
    loading.catch(() => {});  // told below
    if (!canvas.getContext('webgl2', { alpha: false, depth: false, stencil: false, antialias: false, powerPreference: 'high-performance' }))
      return fail('This page needs WebGL 2, which this browser does not show. A present Firefox, Chrome, Edge or Safari does, with its hardware acceleration switched on.');
    const loaded = await loading;
    const { width, height } = size();
    canvas.width = width;
    canvas.height = height;
    const options = { width, height, scale: scale(), bare: address.get('panel') === 'off' };
    for (const name of ['model', 'lecture', 'theme', 'solver']) if (address.get(name)) options[name] = address.get(name);
    let complaint = '';
    const begin = (wanted) => loaded.ccall('page_start', 'string', ['string'], [JSON.stringify(wanted)]);
    if (sceneOfAddress()) try {
      complaint = begin({ ...options, scene: await unpackedScene(sceneOfAddress()) });
    } catch (error) {
      complaint = `The link holds no scene: ${error.message}`;
    }
    if (complaint || !sceneOfAddress()) {
      const wrong = complaint || begin(options);
      if (wrong) {  // the figure, and what was wrong with the address
        const worse = begin({ width, height, scale: scale(), bare: options.bare });
        if (worse) return fail(`${worse[0].toUpperCase()}${worse.slice(1)}.`);
        complaint = wrong;
      }
    }
    module = loaded;
    noNews();
    atFirst = complaint;
    wake();
  })().catch((error) => {
    console.error(error);
    fail(`The sandbox could not be loaded: ${error.message}`);
  });

  /// For tests: what the sandbox says of itself.
  window.gelenk = {
    get frames() { return frames; },
    get firstFrame() { return firstFrame; },
    get resting() { return !asked; },  // nothing is to be drawn now
    get ready() { return frames > 0; },
    status: () => JSON.parse(call('page_status', 'string', [], [])),
    shaderError: (choice) => JSON.parse(call('page_shader_error', 'string', ['string'], [choice])),
    notices: () => JSON.parse(call('page_notices', 'string', [], [])),
    ask: (request) => { const reply = ask({ gelenk: 1, ...request }); wake(); return reply; },
    open,
    kept: () => keeping === 0,
    link: async () => packedScene(call('page_scene', 'string', [], []))
  };
})();
