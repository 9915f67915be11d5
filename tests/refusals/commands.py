"""Lines that commands refuse before they begin. Files that they name: see ``test_commands``."""

from __future__ import annotations

STUDIES = """
identify fit.toml --profiles -1
identify fit.toml --starts 1 --seed 3
identify missing.toml
identify file
sweep missing.toml
sweep file
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
levers e62 --set restitution=0
levers e62 --speed 0
speed-limit --speeds 1000000000
speed-limit --turns 1000000000
speed-limit --least-force nan
speed-limit --from nan
speed-limit --to inf
speed-limit --to 1e300
speed-limit --from=-1e-300
speed-limit --plot limit.xyz
speed-limit --plot limit
speed-limit --plot /dev/null
speed-limit --plot missing/limit.svg
study paper --out here
paper no-such-model
paper --set x
paper --out file
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
simulate --cycles 100000000000000000000 --window cycle
simulate --window cycle --start-index 0
simulate --case missing.json
simulate e62_identified --case case.json
simulate --case case.json --cycles 2
simulate --case case.json --set stops.knee.restitution=0.2
simulate --cycles 2
simulate --start-index 20
simulate --no-reuse
simulate --forces --json -
simulate --units mm
simulate --stiffness 9
check --set springs.steeve.stiffness_N_per_m=9
compare --stiffness 9000 9
simulate --restitution 0.1 --set restitution=0.2
simulate --set restitution=0.1 --set restitution=0.2
simulate --restitution 0.1 --set stops.jaw.restitution=0.2
simulate --out file
simulate --json missing/x.json
simulate --json full
simulate --json /dev/full
simulate --case full
check full
check no-such-model
check loop
check --json - --provenance
check --json - --watch
check no-such-model --watch
view --json -
view --solution missing.npz --html page.html
view --slow nan --html page.html
view --exaggerate 1e9 --html page.html
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
compare e62 file
compare e62 --set-b speed=nan
compare e62 --slow nan --html page.html
compare e62 --html full
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
new mine --urdf missing.urdf
new mine --urdf file --from bell
new --urdf file
new mine --urdf full
new mine.toml --study swep
new mine --study sweep
new fit.toml --study identify
new mine.toml --study sweep --from bell
export e62 e62
export e62 full
export no-such-model mine
"""
SETTINGS = """
check --set points.lip.x_mm=1
check --set points.jaw.y_mm=1
check --set points.jaw=1
check --set points=1
check --set points.jaw.x_mm=far
check --set points.jaw.x_mm=inf
check --set points.jaw.x_mm=nan
check --set points.jaw.x_mm=-72 --set points.jaw.radius_mm=100
check --set points.rod_head.x_mm=-90 --set points.eccentric_pin.x_mm=-91
check --set points.pendulum_shaft.radius_mm=1
check --set points.rod_pin.x_mm=-72.6 --set points.rod_pin.z_mm=101.9
check --set links.rocker.gyration_mm=30 --set links.rocker.inertia_kg_m2=0.0005
check --set links.rocker.colour=1
check --set links.lip.mass_kg=1
check --set links.frame.mass_kg=1
check --set links.rocker.mass_kg=x
check --set links.rocker.mass_kg=0
check --set links.rocker.inertia_kg_m2=1
check --set links.rocker.inertia_kg_m2=inf
check --set urdf=1
check --set urdf.joint=1
check --set urdf.joint.lip.origin.xyz.x=1
check --set urdf.joint.jaw.origin.xyz=1
check --set urdf.joint.jaw.origin.xyz[3]=1
check --set urdf.joint.jaw.origin=1
check --set urdf.joint.jaw.type=1
check --set urdf.link.rocker.inertial.mass.value.x=1
check --set urdf.link.rocker.inertial.weight=1
check --set urdf.link.rocker.inertial.mass.value=-1
check --set urdf.joint.jaw.axis.xyz.z=0.5
check --set urdf.joint.rocker_pin.origin.xyz.x=0.1832
check --set stops.jaw.restitution=much
check --set stops.jaw.restitution=1_0
check --set links.top_nipper.mass_kg=٣
check --set points.rod_pin.x_mm=1_0
check --set restitution=1_
check --set urdf.joint.jaw.origin.xyz.x=1_0
check --set degrees_of_freedom=٣
check --set stops.jaw.restitution=2
check --set stops.jaw.restitution=nan
check --set stops.jaw.bounce=1
check --set stops.lip.restitution=1
check --set stops.jaw=1
check --set stop=1
check --set =1
check --set phases[3].number=1
check --set gravity_m_s2.x=1
check --set 'drives.pendulum.crank_axis_mm=1 2'
check --set degrees_of_freedom=2
check --set simultaneous=both
check --set springs.steeve.file=stiff.csv
check --set stops.jaw.at_mm=1
check --set stops.jaw.contact.lower=lip
check --set stops.jaw.contact.lower=top_plate
check --set stops.jaw.contact.upper=bottom_lip
check --set stops.jaw.contact.lower=cylinder_drum
check --set drives.pendulum.guide_axis_mm[0]=-190.5
check --set drives.pendulum.guide_axis_mm[1]=-20.000002
check small --set springs.coil.force_N[3]=1
check small --set springs.coil.force_N[-1]=1
check small --set springs.coil.force_N[02]=1
check small --set springs.coil.force=1
check small --set springs.coil.force_N[1]=much
check small --set springs.coil.force_N[1]=nan
check small --set springs.coil.coordinate_mm[1]=50
check small --set drives.x.coordinate_rad[8]=1
check small --set drives.x.ratio=1
check small --set drives.x.cylinder_angle_deg[4]=80
check small --set drives.x.coordinate_rad[0]=0.1 --set drives.x.coordinate_rad[7]=0.2
"""
TABLES = {
    name: text.strip().splitlines()
    for name, text in {
        "studies": STUDIES, "runs": RUNS, "comparisons": COMPARISONS, "new": NEW,
        "settings": SETTINGS,
    }.items()
}  # fmt: skip
