"""Gelenk: articulated models, forward and inverse kinematics, skins and motion.

Metres and radians; positions in the world. Quaternions are (w, x, y, z). docs/python.md has every name.
"""

from ._gelenk import *  # noqa: F401,F403
from ._gelenk import version as __version__  # noqa: F401
from ._contract import Contract, check  # noqa: F401
from ._own import Comparison, compare, solver, step_rule  # noqa: F401
from ._page import Page, embed  # noqa: F401
from ._show import Picture, View, program, render, show  # noqa: F401

del version  # noqa: F821  (it is __version__)
