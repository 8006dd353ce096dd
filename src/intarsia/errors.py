"""Everything that intarsia refuses, and with which exit code.

    IntarsiaError            1  the work failed
    |- ParameterError        2  a parameter or an option is out of its range, or does not fit the others
    |- InputError            3  a file or an array is missing, broken, of the wrong size or kind
    |- QualityError          4  a quality gate that was asked for is missed
    |- MissingExtraError     5  an optional package is not installed
    |- MethodError           1  the method cannot serve this exemplar
    |- ResourceError         1  disk full, memory, a folder that cannot be written
    `- CancelledError      130  the caller asked to stop

A message is one line: what was given, what is allowed, what to do.
"""

from __future__ import annotations


class IntarsiaError(Exception):
    """The work failed; the message says in one line what to do."""

    exit_code = 1


class ParameterError(IntarsiaError):
    """A parameter is out of its range, or does not fit the others."""

    exit_code = 2


class InputError(IntarsiaError):
    """A file or an array is missing, broken, of the wrong size or kind."""

    exit_code = 3


class QualityError(IntarsiaError):
    """A quality gate that was asked for is missed."""

    exit_code = 4


class MissingExtraError(IntarsiaError):
    """An optional package is not installed."""

    exit_code = 5


class MethodError(IntarsiaError):
    """The method cannot serve this exemplar."""


class ResourceError(IntarsiaError):
    """The disk is full, memory is short, or a folder cannot be written."""


class CancelledError(IntarsiaError):
    """The caller asked to stop; nothing was written."""

    exit_code = 130
