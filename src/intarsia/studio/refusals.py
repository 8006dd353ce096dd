"""How errors are answered: each in one line, with a status."""

from __future__ import annotations

from typing import Any

from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import JSONResponse, Response

from ..errors import InputError, IntarsiaError, ParameterError
from .safety import TooLargeError


class Refused(Exception):
    """A request that cannot be met as things are; the status tells why."""

    def __init__(self, status: int, line: str) -> None:
        super().__init__(line)
        self.status = status


async def refused(request: Request, e: Exception) -> Response:
    """One line for every error; what is not meant for a client is not told."""
    if isinstance(e, Refused):
        return JSONResponse({"error": str(e)}, e.status)
    if isinstance(e, HTTPException):
        return JSONResponse({"error": str(e.detail)}, e.status_code)
    status = 400 if isinstance(e, ParameterError | InputError) or getattr(e, "exit_code", 1) in (2, 3, 4) else 500
    return JSONResponse({"error": str(e)}, status)


async def wrong(request: Request, e: Exception) -> Response:
    """What nobody thought of: its kind alone is told."""
    return JSONResponse({"error": f"internal error, {type(e).__name__}; please report it."}, 500)


async def too_large(request: Request, e: Exception) -> Response:
    """More came than is taken."""
    return JSONResponse({"error": "this is too large."}, 413)


HANDLERS: dict[Any, Any] = {
    TooLargeError: too_large, IntarsiaError: refused, Refused: refused, HTTPException: refused, Exception: wrong,
}  # fmt: skip
