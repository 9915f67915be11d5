"""Both command lines: that of the package, and that of what measures it."""

from collections.abc import Sequence
from pathlib import Path

from benchmarks.__main__ import COMMANDS
from nipper_pin.cli import NIPPER_PIN, _parser
from nipper_pin.cli import main as run

# Studies that tests run, write or change.
STUDIES = Path(__file__).with_name("studies")
PARSERS = (_parser(), _parser(None, COMMANDS))


def main(words: Sequence[str]) -> int:
    """Run the command of whichever program has it."""
    return run(words, COMMANDS if words and words[0] in COMMANDS.places else NIPPER_PIN)


def study_text(name: str) -> str:
    """The text of a small study."""
    return (STUDIES / name).read_text(encoding="utf-8")
