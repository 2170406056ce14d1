#!/usr/bin/env python3
"""The page in a headless Chromium: it starts, draws, answers, and lets nothing out.

    tests/page_test.py POLHODE [SCREENSHOTS]

Makes a small study of its own, with a scene whose title tries to be markup; with SCREENSHOTS, a folder, it leaves
pictures of what it looked at there. Exit status 77 (skipped) where no Chromium is installed, unless POLHODE_TEST_ALL is set.
"""
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import browser

TITLE = "</script><script>document.title = 'broken'</script><!-- <img src=x onerror=alert(1)> & more"
SCENE = f"""title = {json.dumps(TITLE)}
duration = 4.0
[body]
mass = 1.0
inertia = [0.6, 1.0, 0.8]
[initial]
orientation = [1, 0, 0, 0]
angular_velocity = [0.3, 2.0, 0.1]
"""
SOLVERS = "euler euler-matrix rk4 lie-euler semi-implicit-euler gauss4 dop853 taylor exact odeint-dopri5".split()
READY = "document.documentElement && document.documentElement.dataset.ready"
WEBGL = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")


class Checks:
    """Counts what was looked at; the first word of a failure says what."""

    def __init__(self):
        self.done, self.failures = 0, []

    def expect(self, condition, what):
        self.done += 1
        if not condition:
            self.failures.append(what)
            print("FAILED:", what)


def make_study(polhode, folder):
    scene = folder / "markup.toml"
    scene.write_text(SCENE)
    command = [polhode, "study", "--quick", str(scene), "hairer-vilmart", "-q", "-o", str(folder / "results")]
    for solver in SOLVERS:
        command += ["--solver", solver]
    subprocess.run(command, check=True)
    return folder / "results"


def cheapest(results, scene, bound):
    """The ranking that the page must show, from the table itself: least time of a good run within the bound."""
    best = {}
    with open(results / "work_precision.csv", newline="") as file:
        for row in csv.DictReader(file):
            error, time = row["attitude_error_max_rad"], row["time_min_s"]
            if row["scene"] == scene and row["outcome"] == "ok" and error and time and float(error) <= bound:
                best[row["solver"]] = min(best.get(row["solver"], 1e9), float(time))
    return sorted(best, key=best.get)


def starts(tab, page, checks):
    tab.open(page)
    tab.wait_for(READY)
    print(f"interactive after {tab.run('performance.now() / 1000'):.2f} s")  # told, not asked: machines are shared
    size = pathlib.Path(page).stat().st_size
    checks.expect(size < 4e6, f"size below 4 MB: {size} bytes")


def answers(tab, results, checks):
    shown = "[...document.querySelectorAll('#choose tbody .id')].map((e) => e.textContent)"

    def pick(bound):
        tab.run(f"""{{ const bound = document.getElementById('bound-text'); bound.value = '{bound}';
            bound.dispatchEvent(new Event('change')); }}""")
        return tab.run(shown)

    tab.run("{ const pick = document.getElementById('scene'); pick.value = 'hairer-vilmart'; "
            "pick.dispatchEvent(new Event('change')); }")
    coarse, fine = pick("1e-2"), pick("1e-9")
    checks.expect(fine != coarse, "ranking changes with the bound")
    for bound, rows in ((1e-2, coarse), (1e-9, fine)):
        wanted = cheapest(results, "hairer-vilmart", bound)[:10]
        checks.expect(rows == wanted, f"ranking at {bound}: the page says {rows}, the table {wanted}")
    checks.expect(len(pick("1e-15")) == 0, "nobody is ranked below the rounding floor")
    pick("1e-6")


def chips_work(tab, checks):
    names = tab.run("[...document.querySelectorAll('#work .chip[data-family]')].map((c) => c.dataset.family)")
    checks.expect(len(names) >= 5, f"chips of families: {names}")
    series = "document.querySelector('#work .figure').chart.data.datasets.length"
    for name in names:
        chip = f"[...document.querySelectorAll('#work .chip[data-family]')].find((c) => c.dataset.family === {json.dumps(name)})"
        before = tab.run(series)
        tab.run(f"{chip}.click()")
        off = tab.run(series)
        pressed = tab.run(f"{chip}.getAttribute('aria-pressed')")
        tab.run(f"{chip}.click()")
        checks.expect((off, pressed, tab.run(series)) == (before - 1, "false", before),
                      f"chip {name}: {before} lines, {off} without")
    tab.run("document.querySelector('#work .picker input[value=every]').click()")
    every = tab.run(series)
    tab.run("document.querySelector('#work .picker input[value=best]').click()")
    checks.expect(every > tab.run(series), "every solver is more than the best of each family")


def nothing_blank(tab, checks, what):
    """Looks at every canvas in turn: it must hold more than two colours."""
    blank = tab.run("""(async () => {
        const blank = [];
        // From top to bottom: what is drawn late makes its canvases on the way.
        for (const section of document.querySelectorAll('main > section:not([hidden])')) {
          section.scrollIntoView({behavior: 'instant'});
          await new Promise((done) => setTimeout(done, 80));
          for (const canvas of section.querySelectorAll('canvas')) {
            if (canvas.closest('[hidden]')) continue;
            canvas.parentElement.scrollIntoView({behavior: 'instant', block: 'center'});
            await new Promise((done) => setTimeout(done, 60));
            // What WebGL drew can be read only in the task that drew it: moving the clock draws.
            section.querySelector('.clock input')?.dispatchEvent(new Event('input'));
            const copy = document.createElement('canvas');
            copy.width = copy.height = 200;
            const ctx = copy.getContext('2d');
            ctx.drawImage(canvas, 0, 0, 200, 200);
            const colours = new Set(new Uint32Array(ctx.getImageData(0, 0, 200, 200).data.buffer)).size;
            if (colours < 3) blank.push(`${section.id} ${canvas.className}`);
          }
        }
        scrollTo({top: 0, behavior: 'instant'});
        return blank; })()""")
    checks.expect(blank == [], f"no canvas is blank ({what}): {blank}")


def layout_holds(tab, checks, width, scheme):
    tab.resize(width, 900)
    tab.prefer(scheme)
    tab.run("new Promise((done) => setTimeout(done, 150))")
    over = tab.run("document.documentElement.scrollWidth - innerWidth")
    checks.expect(over <= 0, f"no sideways scrolling at {width} px, {scheme}: {over} px too wide")
    crossed = tab.run("""(() => {
        // Neighbours in the flow of a section must not cover each other, and nothing may stick out of the page.
        const bad = [];
        for (const section of document.querySelectorAll('main > section:not([hidden])')) {
          const boxes = [...section.children].filter((e) => !e.hidden && e.offsetHeight > 0)
            .map((e) => [e, e.getBoundingClientRect()]);
          boxes.forEach(([e, box], i) => {
            if (box.right > innerWidth + 1 || box.left < -1) bad.push(`${section.id}: ${e.className} sticks out`);
            if (i > 0 && box.top < boxes[i - 1][1].bottom - 1) bad.push(`${section.id}: ${e.className} covers its neighbour`);
          });
        }
        const bar = document.querySelector('.bar');
        const parts = [...bar.children].filter((e) => !e.hidden).map((e) => e.getBoundingClientRect());
        parts.forEach((a, i) => parts.slice(i + 1).forEach((b) => {
          if (a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1) bad.push('bar');
        }));
        return bad; })()""")
    checks.expect(crossed == [], f"layout at {width} px, {scheme}: {crossed}")
    dark = tab.run("getComputedStyle(document.body).backgroundColor")
    light = sum(int(part) for part in dark.strip("rgb()").split(",")[:3]) > 384
    checks.expect(light == (scheme == "light"), f"background follows {scheme}: {dark}")


def keeps_to_itself(tab, page, checks, what):
    checks.expect(tab.errors == [], f"console is silent ({what}): {tab.errors}")
    outside = [url for url in tab.requests if not url.startswith(("data:", "blob:")) and not url.endswith("/index.html")
               and url != "about:blank"]
    checks.expect(outside == [], f"no request leaves the page ({what}): {outside}")
    checks.expect(tab.run("document.title").startswith("polhode"), "a title that is markup does no harm")
    named = tab.run("[...document.querySelectorAll('#scene option')].map((o) => o.textContent)")
    checks.expect(tab.run("!/\\[object|undefined|NaN/.test(document.body.innerText)"), "all text is words")
    checks.expect(TITLE in named, f"a title that is markup is shown as it is: {named}")


def main(polhode, screenshots=None):
    if not browser.installed():
        print("no Chromium is installed")
        return 1 if os.environ.get("POLHODE_TEST_ALL") else 77
    checks = Checks()
    with tempfile.TemporaryDirectory(prefix="polhode-page-test-") as folder:
        results = make_study(polhode, pathlib.Path(folder))
        page = results / "index.html"
        with browser.Browser() as tab:  # no WebGL here: bodies are drawn as vectors
            tab.resize(1280, 900)
            tab.prefer("light")
            starts(tab, page, checks)
            answers(tab, results, checks)
            chips_work(tab, checks)
            nothing_blank(tab, checks, "vectors")
            for width, scheme in ((1280, "light"), (1280, "dark"), (360, "dark"), (360, "light")):
                layout_holds(tab, checks, width, scheme)
                if screenshots:
                    tab.screenshot(f"{screenshots}/page-{width}-{scheme}.png", "body")
            keeps_to_itself(tab, page, checks, "vectors")
        with browser.Browser(WEBGL) as tab:
            tab.resize(1280, 900)
            tab.open(page)
            tab.wait_for(READY)
            nothing_blank(tab, checks, "WebGL")
            checks.expect(tab.run("!!document.querySelector('#motion canvas').getContext('webgl')"), "WebGL is used")
            keeps_to_itself(tab, page, checks, "WebGL")
    print(f"{checks.done} checks, {len(checks.failures)} failed")
    return 1 if checks.failures else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
