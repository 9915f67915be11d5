"""Both command lines: that of the package, and that of what measures it."""

from collections.abc import Sequence

from benchmarks.__main__ import COMMANDS
from nipper_pin.cli import NIPPER_PIN, _parser
from nipper_pin.cli import main as run

PARSERS = (_parser(), _parser(None, COMMANDS))


def main(words: Sequence[str]) -> int:
    """Run the command of whichever program has it."""
    return run(words, COMMANDS if words and words[0] in COMMANDS.places else NIPPER_PIN)
