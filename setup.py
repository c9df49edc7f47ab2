"""The Python module of Gelenk: `pip install .` with the distribution's scikit-build, pybind11 and numpy.

There is no pyproject.toml on purpose: with one, pip makes an environment of its own for the build and downloads into it
what Debian has installed already.

GELENK_GRAPHICS=OFF in the environment leaves out the window and the renderer (gelenk.show, gelenk.render).
"""

import os

from skbuild import setup

setup(
    name="gelenk",
    version="0.1.0",
    description="A kinematics and inverse-kinematics research sandbox",
    license="MIT",
    packages=["gelenk"],
    package_dir={"gelenk": "apps/python/gelenk"},
    package_data={"gelenk": ["py.typed", "*.pyi"]},
    cmake_install_dir="apps/python",
    cmake_install_target="install_python",
    cmake_args=[
        "-DGELENK_PYTHON=ON",
        "-DGELENK_TESTS=OFF",
        "-DGELENK_BENCHMARKS=OFF",
        "-DGELENK_GRAPHICS=" + os.environ.get("GELENK_GRAPHICS", "ON"),
    ],
    python_requires=">=3.9",
    install_requires=["numpy"],
    zip_safe=False,
)
