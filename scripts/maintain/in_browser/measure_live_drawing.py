"""What a picture of the live page is made of: it is drawn with one thing taken away.

Run: python scripts/maintain/in_browser/measure_live_drawing.py [WIDTH HEIGHT]

Needs the `dev` extra and Chromium, which draws with the processor here. Each row is the least and
the median of many drawings, taken in turns with those of the other rows, until the last of their
pixels is there.
"""

from __future__ import annotations

import sys

from browser import chromium, live

TIMES = 30
DRAW = """times => {
    const canvas = document.querySelector('canvas[data-engine]');
    const shown = window.__viserMutable.scene, camera = window.__viserMutable.camera;
    const renderer = shown.__r3f.root.getState().gl, gl = renderer.getContext();
    let scene = shown;
    while (scene.parent) scene = scene.parent;
    const finish = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    const solids = [], behind = [], suns = [], plain = [];
    scene.traverse(item => {
        const kind = item.material && item.material.type;
        if (kind === 'MeshToonMaterial') solids.push(item);
        if (kind === 'ShaderMaterial' && item.visible) behind.push(item);
        if (kind === 'MeshBasicMaterial') plain.push(item.material);
        if (item.isDirectionalLight) suns.push(item);
    });
    const most = Math.max(...solids.map(item => item.geometry.index.count));
    const springs = solids.filter(item => item.geometry.index.count === most);
    const lit = solids.map(item => item.material);
    const unlit = toneMapped => lit.map(item => new plain[0].constructor(
        {color: item.color, side: item.side, toneMapped}));
    const flat = unlit(true), raw = unlit(false);
    const hide = list => [() => list.forEach(item => { item.visible = false; }),
                          () => list.forEach(item => { item.visible = true; })];
    const paint = given => [() => solids.forEach((item, k) => { item.material = given[k]; }),
                            () => solids.forEach((item, k) => { item.material = lit[k]; })];
    const seen = solids.filter(item => item.visible);
    const rows = {
        'the whole': [() => {}, () => {}],
        'without the solids': hide(seen),
        'without the background': hide(behind),
        'into a single pixel': [() => renderer.setViewport(0, 0, 1, 1),
                                () => renderer.setViewport(0, 0, canvas.width, canvas.height)],
        'without the sun': hide(suns),
        'without any light': paint(flat),
        'without light and tone mapping': paint(raw),
        'without the springs': hide(springs),
    };
    const taken = {};
    for (let round = 0; round < times; round++)
        for (const [name, [change, restore]] of Object.entries(rows)) {
            change();
            renderer.render(scene, camera);
            finish();
            const began = performance.now();
            for (let k = 0; k < 3; k++) renderer.render(scene, camera);
            finish();
            (taken[name] = taken[name] || []).push((performance.now() - began) / 3);
            restore();
        }
    return {size: `${canvas.width} x ${canvas.height}`, taken};
}"""


def main(width: str = "900", height: str = "700") -> None:
    """Print the table."""
    with live("--speed", "650") as address, chromium() as browser:
        page = browser.new_page(viewport={"width": int(width), "height": int(height)})
        page.set_default_timeout(120_000)
        page.goto(f"{address}?fixedDpr=1")
        page.wait_for_selector("#setting")
        page.wait_for_timeout(2000)
        page.get_by_label("play").click()
        page.wait_for_timeout(1500)
        found = page.evaluate(DRAW, TIMES)
    print(f"{'canvas ' + found['size'] + ', milliseconds':34}{'least':>8}{'median':>8}")
    for name, values in found["taken"].items():
        ordered = sorted(values)
        print(f"{name:34}{ordered[0]:8.1f}{ordered[len(ordered) // 2]:8.1f}")


if __name__ == "__main__":
    main(*sys.argv[1:3])
