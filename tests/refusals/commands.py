"""Lines that commands refuse before they begin. Files that they name: see ``test_commands``."""

from __future__ import annotations

STUDIES = """
identify fit.toml --profiles -1
identify fit.toml --starts 1 --seed 3
identify missing.toml
sweep sweep.toml --chunks a-2
sweep sweep.toml --workers 0 --dry-run
sweep sweep.toml --dry-run --out here
sweep sweep.toml --dry-run --scheduler tcp://a:1
sweep sweep.toml --out file
sweep sweep.toml --out file/below
optimise one.toml --points 3
optimise one.toml --format png
optimise one.toml --starts 0
optimise one.toml --workers 0
optimise two.toml --points 0
plot full
plot nowhere
study speed-limit e62 --plot x.svg
study paper --out here
study --help
run --repeats 0
"""
RUNS = """
simulate --speed 0
simulate --speed nan
simulate --restitution 1.5
simulate --stiffness -1
simulate --set stops.jaw
simulate --set stops.knee.restitution=0.1
simulate --set preloda=3
simulate no-such-model
simulate --cycles 0 --window cycle
simulate --window cycle --start-index 0
simulate --case missing.json
simulate e62_identified --case case.json
simulate --case case.json --cycles 2
simulate --case case.json --set stops.knee.restitution=0.2
simulate --cycles 2
simulate --start-index 20
simulate --no-reuse
simulate --forces --json -
simulate --restitution 0.1 --set restitution=0.2
simulate --set restitution=0.1 --set restitution=0.2
simulate --restitution 0.1 --set stops.jaw.restitution=0.2
simulate --out file
simulate --json missing/x.json
check no-such-model
check --json - --provenance
view --json -
view --html page.html --port 0
view --gif film.gif --no-browser
view --window transition --start-index 0
view --solution before.npz e62
view --solution before.npz --set preload=1
view --solution before.npz --restitution 0
view --solution before.npz --stiffness 9000
view --solution before.npz --speed 450
view --solution before.npz --window cycle
view --solution before.npz --start-index 24
"""
COMPARISONS = """
compare e62 e62 --speed 450 500 e62
compare before.npz e62 --set-b speed=fast
compare e62 --speed 450 --set-b speed=500
compare e62 --set preload=9 --set-b preload=8
compare before.npz --cycles 2
compare e62 out --drive held inertial
compare before.npz --set-b preload=9 --drive held
compare e62 --cycles 2 --window transition
compare e62 --exaggerate 5
compare e62 --browser --json -
compare e62 nowhere
compare missing.npz e62
compare before.npz cycle.npz
compare e62 other/mine.toml
compare e62 broken.npz
"""
NEW = """
new
new --list a
new --list --from a
new e62
new 'a b'
new 1st
new full
new file
new file/press
"""
TABLES = {
    name: text.strip().splitlines()
    for name, text in {
        "studies": STUDIES, "runs": RUNS, "comparisons": COMPARISONS, "new": NEW,
    }.items()
}  # fmt: skip
