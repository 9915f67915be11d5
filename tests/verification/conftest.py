import sys
from pathlib import Path

# The published problems state their own equations in a module beside the tests.
sys.path.insert(0, str(Path(__file__).parent))
