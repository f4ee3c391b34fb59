"""Builds the wheel for `pip install src/python`: the package, and beside it build/libdelassus.so.0
of the tree or what DELASSUS_LIBRARY names. A wheel is a zip file: Python alone can write it, and no
network is needed."""

import base64
import hashlib
import os
import pathlib
import re
import sysconfig
import zipfile

_HERE = pathlib.Path(__file__).resolve().parent
_NAME = "libdelassus.so.0"


def _project(key):
    text = (_HERE / "pyproject.toml").read_text()
    return re.search(rf'^{key} = "(.*)"$', text, re.M).group(1)


def _row(path, data):
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return f"{path},sha256={digest},{len(data)}\n"


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    version = _project("version")
    library = pathlib.Path(os.environ.get("DELASSUS_LIBRARY") or _HERE.parents[1] / "build" / _NAME)
    if not library.exists():
        raise SystemExit(f"no {library}: run make first")
    tag = "py3-none-" + re.sub("[-.]", "_", sysconfig.get_platform())
    info = f"delassus-{version}.dist-info"
    files = {f"delassus/{source.name}": source.read_bytes()
             for source in sorted((_HERE / "delassus").glob("*.py"))}
    files[f"delassus/{_NAME}"] = library.read_bytes()
    files[f"{info}/METADATA"] = (f"Metadata-Version: 2.1\nName: delassus\nVersion: {version}\n"
                                 f"Summary: {_project('description')}\nRequires-Dist: numpy\n"
                                 "Requires-Dist: scipy\n").encode()
    files[f"{info}/WHEEL"] = ("Wheel-Version: 1.0\nGenerator: delassus\nRoot-Is-Purelib: false\n"
                              f"Tag: {tag}\n").encode()
    name = f"delassus-{version}-{tag}.whl"
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():
            wheel.writestr(path, data)
        record = "".join(_row(path, data) for path, data in files.items())
        wheel.writestr(f"{info}/RECORD", record + f"{info}/RECORD,,\n")
    return name
