"""What pyproject.toml cannot say: the version stands in a header, and the wheel carries the library,
which make builds. DELASSUS_LIBRARY names one that is built already."""

import os
import pathlib
import re
import shutil
import subprocess

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py
from wheel.bdist_wheel import bdist_wheel

ROOT = pathlib.Path(__file__).resolve().parent
NAME, FILES = "libdelassus.so.0", "libdelassus-files.so.0"


def version():
    header = (ROOT / "include/delassus/status.h").read_text()
    return re.search(r'define DLS_VERSION +"(.*)"', header).group(1)


class BuildLibrary(build_py):
    """Puts the libraries beside the modules; an editable install finds it in build/."""

    def run(self):
        super().run()
        given = os.environ.get("DELASSUS_LIBRARY")
        make = ["make", "-j", str(os.cpu_count() or 1), "HDF5=0"]
        if not given:
            subprocess.run([*make, "build/libdelassus.so"], cwd=ROOT, check=True)
        if self.editable_mode:
            return
        # of its own build: that of the tree may read FCLIB, and need HDF5
        subprocess.run([*make, "BUILD=build/wheel", "build/wheel/libdelassus-files.so"], cwd=ROOT, check=True)
        place = pathlib.Path(self.build_lib, "delassus")
        shutil.copy(given or ROOT / "build" / NAME, place / NAME)
        shutil.copy(ROOT / "build/wheel" / FILES, place / FILES)


class PlatformWheel(bdist_wheel):
    """One wheel for every Python 3: nothing is compiled against the interpreter."""

    def get_tag(self):
        return "py3", "none", super().get_tag()[2]


class BinaryDistribution(Distribution):
    """A package with a library in it belongs to one platform."""

    def has_ext_modules(self):
        return True


setup(version=version(), distclass=BinaryDistribution, options={"build": {"build_base": "build/python"}},
      cmdclass={"build_py": BuildLibrary, "bdist_wheel": PlatformWheel})
