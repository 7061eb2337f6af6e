# SPDX-License-Identifier: Apache-2.0
from typing import Any, Optional

__version__: str

class Error(RuntimeError):
    """What went wrong, in one sentence. `code` is as the exit codes of the program: 1 failed, 2 usage, 3 unusable input, 4 a promised
    invariant failed.
    """
    code: int
    argument: Optional[str]

class UsageError(Error, ValueError):
    """An invalid argument: an `Error` of code 2, and a `ValueError`. `argument` is the name of the keyword."""

def __getattr__(name: str) -> Any: ...
