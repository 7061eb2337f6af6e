# SPDX-License-Identifier: Apache-2.0
from typing import Any, Optional

__version__: str

class Error(RuntimeError):
    code: int
    argument: Optional[str]

class UsageError(Error, ValueError): ...

def __getattr__(name: str) -> Any: ...
