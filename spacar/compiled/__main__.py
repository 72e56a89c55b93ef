"""`python -m spacar.compiled`: says in one line whether the engine is there; status 1 when it is not."""

import sys

from spacar.compiled.library import level, unavailable

reason = unavailable()
print(f"spacar: {reason}; runs take longer" if reason else f"spacar: the compiled engine is there ({level()})")
sys.exit(reason is not None)
