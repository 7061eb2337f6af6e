# SPDX-License-Identifier: Apache-2.0
from typing import Any, Optional

__version__: str

class Error(RuntimeError):
    """What went wrong, in one sentence. `code` is as the exit codes of the program: 1 failed, 2 usage, 3 unusable input, 4 a promised
    invariant failed.
    """
    code: int
    argument: Optional[str]

class UsageError(Error, ValueError): ...

def __getattr__(name: str) -> Any: ...
