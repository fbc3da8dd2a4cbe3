import sys
from pathlib import Path

TESTS = Path(__file__).parents[1]

sys.path.insert(0, str(TESTS.parent / "scripts"))  # `verify_ladder`, `verification`
sys.path.append(str(TESTS / "bilayer"))  # `made_results`
