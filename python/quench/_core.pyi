# SPDX-License-Identifier: Apache-2.0
from typing import Any

__version__: str

class Error(RuntimeError):
    code: int

def __getattr__(name: str) -> Any: ...
