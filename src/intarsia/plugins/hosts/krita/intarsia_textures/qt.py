"""The Qt that Krita itself has loaded: Krita 5 is Qt 5, Krita 6 is Qt 6, and a process bears but one."""

import sys

import krita  # noqa: F401 - loads it

if "PyQt6.QtCore" in sys.modules:
    from PyQt6 import QtCore, QtGui, QtWidgets
else:
    from PyQt5 import QtCore, QtGui, QtWidgets

__all__ = ["QtCore", "QtGui", "QtWidgets"]
