"""What a frame of ``polhode view`` costs its script.

A browser without a window (Chromium) draws 2000 frames with all calls of WebGL but the drawing
itself, which is the graphics card's part; and some whole ones, each waited for, that the processor
draws for want of a graphics card, as many pixels as the page's window has.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator
from html import unescape
from pathlib import Path
from typing import Any

import polhode
from measure.benchmark import Line

SWITCHES = [
    *("--headless", "--no-sandbox", "--no-first-run", "--disable-sync", "--disable-quic"),
    *("--disable-background-networking", "--use-gl=angle", "--use-angle=swiftshader"),
    *("--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"),
]
BATCHES, FRAMES = 40, 50

_PROBE = """
<script>(() => {
  const all = {path: true, sphere: true, omega: true}, found = {calls: 0, triangles: 0};
  const frame = t => { time = t; for (const view of views) view.draw(t, all); tell(); };
  const contexts = views.map(view => view.painter.gl), kind = WebGL2RenderingContext.prototype;
  for (const gl of contexts)
    for (const name of Object.getOwnPropertyNames(kind)) {
      if (Object.getOwnPropertyDescriptor(kind, name).get) continue;
      if (typeof gl[name] !== "function") continue;
      const call = gl[name].bind(gl);
      gl[name] = (...given) => {
        found.calls += 1;
        if (name === "drawArrays")
          found.triangles += {4: given[2] / 3, 5: given[2] - 2}[given[0]] || 0;
        return call(...given);
      };
    }
  frame(motion.end);
  const counted = {...found};
  const pixel = new Uint8Array(4), drawn = Array.from({length: 12}, (_, k) => {
    const began = performance.now();
    frame(motion.begin + (motion.end - motion.begin) * k / 12);
    for (const gl of contexts) gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    return performance.now() - began;
  }).sort((a, b) => a - b);
  Object.assign(found, counted, {drawn: drawn[6]});
  for (const gl of contexts) {
    for (const name of Object.keys(gl)) delete gl[name];
    gl.drawArrays = () => {};
  }
  const batches = Array.from({length: BATCHES}, (_, b) => {
    const began = performance.now();
    for (let k = 0; k < FRAMES; k++)
      frame(motion.begin + (motion.end - motion.begin) * ((b * FRAMES + k) % 997) / 997);
    return (performance.now() - began) / FRAMES;
  }).sort((a, b) => a - b);
  Object.assign(found, {least: batches[0], median: batches[BATCHES >> 1]});
  found.canvas = views.map(view => view.canvas.width);
  const told = document.createElement("pre");
  told.id = "probe"; told.textContent = JSON.stringify(found);
  document.body.append(told);
})();</script></body>""".replace("BATCHES", str(BATCHES)).replace("FRAMES", str(FRAMES))


def browser() -> str | None:
    """A browser that needs no window, where there is one."""
    return shutil.which("chromium") or shutil.which("google-chrome")


def cost(page: polhode.Page, width: int) -> dict[str, Any]:
    """Milliseconds of script a frame (least and median of the batches), of a frame that the
    processor draws (``drawn``), WebGL calls, triangles."""
    program = browser()
    if program is None:
        raise RuntimeError("no browser here")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "page.html"
        path.write_text(page.text.replace("</body>", _PROBE), encoding="utf-8")
        given = [f"--user-data-dir={folder}/profile", f"--window-size={width},1300", "--dump-dom"]
        address = f"{path.as_uri()}#play=0"
        command = [program, *SWITCHES, *given, address]
        done = subprocess.run(command, capture_output=True, timeout=200, text=True, check=True)
    (told,) = re.findall(r'<pre id="probe">(.*?)</pre>', done.stdout)
    found: dict[str, Any] = json.loads(unescape(told))
    return found


def frames(seconds: float) -> Iterator[Line]:
    """Milliseconds of script a frame, least and median, and what a frame is made of."""
    del seconds  # the page itself says how many frames it draws
    if browser() is None:
        yield Line("not measured without a browser, chromium or google-chrome", "")
        return
    for name in ("lagrange/looping", "euler/largest-axis", "general/asymmetric-regular"):
        for width in (400, 1400):
            x = cost(polhode.view(name), width)
            yield Line(f"{name}, {width} px: ms", f"{x['least']:.2f}, median {x['median']:.2f}")
            told = f"{x['calls']} calls, {x['triangles']:.0f} triangles"
            yield Line("  drawn by the processor, ms", f"{x['drawn']:.0f}; {told}")
