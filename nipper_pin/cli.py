"""The command ``nipper-pin``."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .dynamics.system import DriveMode
from .errors import InputError, NipperError, UnknownNameError
from .hybrid.case import Case, Resolution, Window
from .hybrid.record import record
from .hybrid.simulate import simulate
from .hybrid.solution import Solution
from .hybrid.storage import complete_file, load_case
from .mechanism import Mechanism, load

_RIGHT, _NOT_SIMULATED, _UNUSABLE, _INTERRUPTED = 0, 1, 2, 130


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Args:
        arguments: Command-line arguments; those of the process by default.

    Returns:
        Exit status: 0 right, 1 the simulation could not be done, 2 unusable arguments or files.
    """
    options = _parser().parse_args(arguments)
    try:
        options.run(options)
    except InputError as error:
        return _complain(error, _UNUSABLE)
    except NipperError as error:
        return _complain(error, _NOT_SIMULATED)
    except KeyboardInterrupt:
        return _INTERRUPTED
    except BrokenPipeError:
        # The reader of a pipe may stop early; that is not a fault of the run.
        sys.stderr.close()
    return _RIGHT


def _complain(error: NipperError, status: int) -> int:
    sys.stderr.write(f"nipper-pin: {error.message}\n")
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="nipper-pin",
        description="Simulate impact mechanisms: the nipper of a comber and its bouncing jaw.",
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    _add_simulate(commands.add_parser("simulate", help="simulate a transition or whole cycles"))
    _add_check(commands.add_parser("check", help="say what a model is, and what is wrong with it"))
    _add_benchmark(
        commands.add_parser("benchmark", help="measure run time against error on this machine")
    )
    return parser


def _add_model(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "model",
        nargs="?",
        default="e62",
        metavar="MODEL",
        help="name of a model that comes with the package, or a folder",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="PATH=VALUE",
        help="change a number of the model, for example "
        "stops.steeve.restitution=0.1; may be repeated",
    )
    parser.add_argument("--restitution", type=float, metavar="E", help="restitution of the jaw")
    parser.add_argument(
        "--stiffness", type=float, metavar="N_PER_M", help="spring rate; the preload length is kept"
    )
    parser.add_argument(
        "--speed",
        type=float,
        metavar="RPM",
        help="cylinder speed (default: the model's rated speed)",
    )
    parser.add_argument("--json", metavar="FILE", help="write the result as JSON; - for stdout")


def _add_simulate(parser: argparse.ArgumentParser) -> None:
    _add_model(parser)
    parser.add_argument(
        "--window",
        choices=[item.value for item in Window],
        default=Window.TRANSITION.value,
        help="transition: first collision to rest; cycle: whole turns",
    )
    parser.add_argument("--cycles", type=int, default=1, metavar="N", help="number of turns")
    parser.add_argument(
        "--start-index",
        type=float,
        default=24.0,
        metavar="INDEX",
        help="index at which the turns start (default 24, foremost)",
    )
    parser.add_argument(
        "--drive",
        choices=[item.value for item in DriveMode],
        default=DriveMode.HELD.value,
        help="held: impacts cannot change the shafts' speed; inertial: they can",
    )
    parser.add_argument(
        "--rest-rate",
        type=float,
        metavar="RATE",
        help="end a series of bounces at this separation rate (rad/s or m/s) "
        "instead of at its limit",
    )
    parser.add_argument(
        "--tolerance",
        type=float,
        default=1e-12,
        metavar="TOL",
        help="relative accuracy (default 1e-12)",
    )
    parser.add_argument(
        "--no-reuse", action="store_true", help="compute turns that repeat exactly again"
    )
    parser.add_argument(
        "--forces", action="store_true", help="add clamping and stop forces to the table"
    )
    parser.add_argument(
        "--out",
        metavar="DIR",
        help="write CSV tables, the solution, the case and plots into a folder",
    )
    parser.add_argument(
        "--case", metavar="FILE", help="repeat the run of a case.json that --out wrote"
    )
    parser.set_defaults(run=_simulate)


def _add_check(parser: argparse.ArgumentParser) -> None:
    _add_model(parser)
    parser.set_defaults(run=_check)


def _add_benchmark(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--quick", action="store_true", help="fewer settings and repeats: less than a minute"
    )
    parser.add_argument(
        "--repeats",
        type=int,
        metavar="N",
        help="runs of each setting after the first (default 30, quick 10)",
    )
    parser.add_argument("--json", metavar="FILE", help="write the result as JSON; - for stdout")
    parser.add_argument("--out", metavar="DIR", help="write JSON, tables and a plot into a folder")
    parser.set_defaults(run=_benchmark)


def _simulate(options: argparse.Namespace) -> None:
    if options.case is not None:
        mechanism, case = load_case(options.case)
    else:
        mechanism = _mechanism(options)
        case = Case(
            speed_rpm=_speed(options, mechanism),
            window=Window(options.window),
            cycles=options.cycles,
            start_index=options.start_index,
            drive=DriveMode(options.drive),
            rest_rate=options.rest_rate,
            resolution=Resolution(tolerance=options.tolerance),
            reuse_cycles=not options.no_reuse,
        )
    with _progress(case) as advance:
        solution = simulate(mechanism, case, advance)
    if options.out is not None:
        from .view.export import export

        export(solution, options.out)
    if options.json is not None:
        _write_json(record(solution), options.json)
    if options.json != "-":
        _print(solution, forces=options.forces)


def _check(options: argparse.Namespace) -> None:
    from .study.check import check_model

    mechanism = _mechanism(options)
    report = check_model(mechanism, _speed(options, mechanism))
    if options.json is not None:
        _write_json(report.record(), options.json)
    if options.json != "-":
        from rich.console import Console

        from .view.report import print_report

        print_report(report, Console())


def _benchmark(options: argparse.Namespace) -> None:
    from .study.benchmark import benchmark

    if options.repeats is not None and options.repeats < 1:
        message = f"--repeats {options.repeats}: at least 1"
        raise InputError(message, argument=options.repeats)

    def pictures(solution: Solution, folder: Path) -> object:
        from .view.plots import plot_solution

        return plot_solution(solution, folder)

    def say(text: str) -> None:
        if sys.stderr.isatty():
            sys.stderr.write(f"{text} ...\n")

    result = benchmark(quick=options.quick, repeats=options.repeats, pictures=pictures, say=say)
    if options.out is not None:
        from .view.benchmark_files import write_benchmark

        write_benchmark(result, options.out)
    if options.json is not None:
        _write_json(result.record(), options.json)
    if options.json != "-":
        from rich.console import Console

        from .view.benchmark_report import print_benchmark

        print_benchmark(result, Console())


def _mechanism(options: argparse.Namespace) -> Mechanism:
    overrides: dict[str, object] = {}
    for item in options.set:
        path, equals, value = item.partition("=")
        if not equals:
            message = f"--set {item}: write PATH=VALUE, for example stops.jaw.restitution=0.1"
            raise InputError(message, argument=item)
        overrides[path.strip()] = value.strip()
    mechanism = load(options.model, overrides)
    short = {
        name: value
        for name in ("restitution", "stiffness")
        if (value := getattr(options, name)) is not None
    }
    if not short:
        return mechanism
    for name in short:
        if name not in mechanism.shortcuts:
            raise UnknownNameError(
                kind="shortcut", name=name, known=mechanism.shortcuts, where=options.model
            )
    return load(
        options.model,
        {**overrides, **{mechanism.shortcuts[name]: value for name, value in short.items()}},
    )


def _speed(options: argparse.Namespace, mechanism: Mechanism) -> float:
    if options.speed is not None:
        return float(options.speed)
    return mechanism.cylinder.rated_speed_rpm


def _write_json(document: dict[str, Any], target: str) -> None:
    text = json.dumps(document, indent=1, allow_nan=False) + "\n"
    if target == "-":
        sys.stdout.write(text)
        return
    with complete_file(Path(target)) as partial:
        partial.write_text(text, encoding="utf-8")


def _print(solution: Solution, *, forces: bool) -> None:
    from rich.console import Console

    from .view.table import print_solution

    print_solution(solution, Console(), forces=forces)


@contextmanager
def _progress(case: Case) -> Iterator[Any]:
    """Progress of many turns, on a terminal only."""
    if case.window is not Window.CYCLE or case.cycles < 3 or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("turns", total=case.cycles)
        yield lambda done, total: bar.update(task, completed=done, total=total)
