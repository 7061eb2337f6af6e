# SPDX-License-Identifier: Apache-2.0
from typing import Any

__version__: str

class Error(RuntimeError):
    """What went wrong, in one sentence. `code` is as the exit codes of the program: 1 failed, 2 usage, 3 unusable input, 4 a promised
    invariant failed.
    """
    code: int

def __getattr__(name: str) -> Any: ...
