"""Finds libdelassus, builds its structs from the table of layouts that it carries
(delassus/layout.h), and declares the functions that the package calls. What does not fit is an
ImportError."""

from __future__ import annotations

import ctypes
import difflib
import functools
import operator
import os
import pathlib
import re
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_size_t, c_void_p
from typing import (Any, Callable, Dict, Generator, Iterable, List, Mapping, NoReturn, Protocol, Tuple,
                    Union)

import numpy as np
import numpy.typing as npt


class SparseMatrix(Protocol):
    """Any matrix of scipy.sparse."""

    shape: Any

    def tocsc(self, copy: bool = ...) -> Any: ...


Vector = npt.NDArray[np.float64]
Array = npt.ArrayLike
Matrix = Union[npt.ArrayLike, SparseMatrix]

_NAME = "libdelassus.so.0"


def find_library(name: str, variable: str) -> ctypes.CDLL:
    """Returns a library: the one that an environment variable names, else the one beside the
    package (pip), in a directory or a build/ above it (make install-python, the source tree), else
    what the loader finds."""
    named = os.environ.get(variable)
    here = pathlib.Path(__file__).resolve().parent
    places = [here / name]
    for above in here.parents[:4]:
        places += [above / name, above / "build" / name]
    found = named or next((str(place) for place in places if place.exists()), name)
    try:
        return ctypes.CDLL(found)
    except OSError as reason:
        raise ImportError(f"delassus: no {name} ({reason}); {variable} may name it") from reason


lib = find_library(_NAME, "DELASSUS_LIBRARY")


# ---- structs and constants, from the library's own table -----------------------------------------


class _Field(ctypes.Structure):
    _fields_ = [("record", c_char_p), ("name", c_char_p), ("type", c_char_p),
                ("offset", c_size_t), ("size", c_size_t), ("count", c_size_t)]


class _Constant(ctypes.Structure):
    _fields_ = [("name", c_char_p), ("value", c_int)]


_TYPES = {"int": c_int, "double": c_double, "size_t": c_size_t, "long long": ctypes.c_longlong,
          "char": ctypes.c_char, "pointer": c_void_p, "function": c_void_p}

# the fields that the package reads or sets
_USED = {
    "dls_error": "status function argument index value message",
    "dls_limits": "tol max_iterations warm_start blocks progress progress_data cpu_seconds "
                  "threads",
    "dls_progress": "method stage iteration max_iterations residual r cpu_seconds last",
    "dls_paced": "progress progress_data seconds next",
    "dls_solver_settings": "limits size method acceleration facets positive_definite forces plan "
                           "without",
    "dls_certificate": "residual residual_u residual_r floor_u floor_r penetration adhesion "
                       "cone_violation slip_direction complementarity worst "
                       "equilibrium floor_e unbalanced body",
    "dls_info": "status method iterations certificate error ambiguous unique stages stage regime "
                "forces",
    "dls_stage": "method iterations factorisations residual step reason on_copy ahead next "
                 "cpu_seconds",
    "dls_dense": "rows cols ld a",
    "dls_sparse": "rows cols p i x",
    "dls_blocks": "d n p i x",
    "dls_bodies": "n count body H work",
    "dls_contact": "d nc W Wb q mu bodies weights",
    "dls_lcp": "n M q Ms",
    "dls_lcp_certificate": "residual floor negative_z negative_y complementarity worst",
    "dls_lemke_settings": "limits size",
    "dls_lemke_info": "status pivots certificate crash_rounds",
    "dls_principal_settings": "limits size",
    "dls_principal_info": "status iterations certificate",
    "dls_model": "d n nodes operator_kind factorization K Ks solve user HN HT P active mu "
                 "triangular",
    "dls_reduction_settings": "size on loads memory_limit allow_indefinite form_W "
                              "frictionless progress progress_data surface surface_count",
    "dls_surfaces": "d n points base X dof nodes node faces corners face wall own_faces own_corners "
                    "own reach",
    "dls_pairs": "nodes candidates HN HT P g frame face node measure state",
    "dls_rigid": "mass inertia R x v w",
    "dls_reduction_info": "on contacts condensed W_bytes factor_bytes bytes flops condition indefinite "
                          "joints redundant",
    "dls_limit_settings": "limits size from to tol most",
    "dls_limit": "carried refused proved open solves unique",
    "dls_derive_data": "mu q W f g K",
    "dls_derive_answer": "r u x",
    "dls_motion_model": "d n nodes factorization M C K HN HT P gap",
    "dls_motion_settings": "limits size law method h theta restitution activation forecast "
                           "energy_consistent",
    "dls_motion_state": "d n candidates steps t x v p u gap slip state active active_list "
                        "restitution",
    "dls_motion_energies": "kinetic elastic load damping obstacle friction impact numerical "
                           "residual scale momentum created",
}


_Row = Tuple[str, str, int, int, int]  # name, type, offset, size, count
_Fields = Dict[str, List[_Row]]


def _read_tables() -> tuple[_Fields, dict[str, int], str]:
    try:
        next_field, next_constant = lib.dls_layout_field, lib.dls_layout_constant
        lib.dls_version.restype = c_char_p
        version = lib.dls_version().decode()
    except AttributeError as missing:
        raise ImportError(f"delassus: this is no libdelassus: {missing}") from missing
    next_field.restype, next_constant.restype = POINTER(_Field), POINTER(_Constant)
    fields: _Fields = {}
    constants: dict[str, int] = {}
    k = 0
    while next_field(k):
        f = next_field(k).contents
        fields.setdefault(f.record.decode(), []).append(
            (f.name.decode(), f.type.decode(), f.offset, f.size, f.count))
        k += 1
    k = 0
    while next_constant(k):
        c = next_constant(k).contents
        constants[c.name.decode()] = c.value
        k += 1
    return fields, constants, version


def _mismatch(record: str, what: str) -> NoReturn:
    raise ImportError(f"delassus: {record} of the library is another one: {what}")


def _check(struct: type[ctypes.Structure], record: str, rows: list[_Row]) -> None:
    """Compares a ctypes struct with the rows of the table."""
    if ctypes.sizeof(struct) != rows[0][3]:
        _mismatch(record, f"{rows[0][3]} bytes, not {ctypes.sizeof(struct)}")
    for name, _, offset, size, _ in rows[1:]:
        field = getattr(struct, name, None)
        if field is None or (field.offset, field.size) != (offset, size):
            _mismatch(record, f"field {name}")


def _build(fields: _Fields) -> dict[str, Any]:
    structs: dict[str, Any] = {}
    for record, rows in fields.items():
        declared = []
        for name, kind, _, _, count in rows[1:]:
            one: Any = _TYPES.get(kind) or structs.get(kind)
            if one is None:
                _mismatch(record, f"type {kind} of {name}")
            declared.append((name, one * count if count > 1 else one))
        # without __slots__ a misspelt field would become a new attribute
        structs[record] = type(record, (ctypes.Structure,), {"__slots__": (), "_fields_": declared})
        _check(structs[record], record, rows)
    for own, record in ((_Field, "dls_field"), (_Constant, "dls_constant")):
        if not fields.get(record):
            _mismatch(record, "missing")
        _check(own, record, fields[record])
    for record, names in _USED.items():
        if record not in structs:
            _mismatch(record, "missing")
        lost = set(names.split()) - {row[0] for row in fields[record]}
        if lost:
            _mismatch(record, f"no field {sorted(lost)[0]}")
    return structs


_fields, constants, VERSION = _read_tables()
structs = _build(_fields)


# ---- functions -----------------------------------------------------------------------------------

_SIGNATURES = {
    "dls_solver_settings_init": (None, "p"),
    "dls_reduction_settings_init": (None, "p"),
    "dls_motion_settings_init": (None, "p"),
    "dls_progress_paced": (c_int, "pp"),
    "dls_method_find": (c_int, "sp"),
    "dls_acceleration_find": (c_int, "sp"),
    "dls_method_name": (c_char_p, "i"),
    "dls_step_name": (c_char_p, "i"),
    "dls_reason_text": (c_char_p, "i"),
    "dls_regime_name": (c_char_p, "i"),
    "dls_explain": (c_size_t, "ppz"),
    "dls_status_name": (c_char_p, "i"),
    "dls_status_text": (c_char_p, "i"),
    "dls_solved": (c_int, "i"),
    "dls_certificate_holds": (c_int, "pd"),
    "dls_contact_certify": (c_int, "ppppp"),
    "dls_contact_states": (c_int, "ppppp"),
    "dls_contact_misfits": (c_int, "ppppp"),
    "dls_contact_prove": (c_int, "ppppp"),
    "dls_contact_fold": (c_int, "ppppppp"),
    "dls_contact_freedom": (c_int, "pppp"),
    "dls_derive_create": (c_int, "pppip"),
    "dls_derive_create_body": (c_int, "pppppip"),
    "dls_derive_vjp": (c_int, "pppp"),
    "dls_derive_jvp": (c_int, "pppp"),
    "dls_derive_destroy": (None, "p"),
    "dls_solve": (c_int, "pppppp"),
    "dls_solve_batch": (c_int, "ipppppp"),
    "dls_solver_create": (c_int, "piipp"),
    "dls_solver_set_limits": (c_int, "ppp"),
    "dls_solver_map": (c_int, "pippp"),
    "dls_solver_solve": (c_int, "pppppp"),
    "dls_solver_destroy": (None, "p"),
    "dls_lemke_settings_init": (None, "p"),
    "dls_lemke_create": (c_int, "pipp"),
    "dls_lemke_solve": (c_int, "pppppp"),
    "dls_lemke_farkas": (c_int, "ppp"),
    "dls_lemke_destroy": (None, "p"),
    "dls_principal_settings_init": (None, "p"),
    "dls_principal_create": (c_int, "pipp"),
    "dls_principal_solve": (c_int, "pppppp"),
    "dls_principal_destroy": (None, "p"),
    "dls_reduction_create": (c_int, "pppp"),
    "dls_reduction_update": (c_int, "ppp"),
    "dls_reduction_get_info": (c_int, "ppp"),
    "dls_reduction_load": (c_int, "pppp"),
    "dls_reduction_load_free": (c_int, "pppp"),
    "dls_reduction_contact": (c_int, "pppp"),
    "dls_reduction_recover": (c_int, "pppp"),
    "dls_reduction_solve": (c_int, "pppppppp"),
    "dls_reduction_states": (c_int, "pppppp"),
    "dls_reduction_certify": (c_int, "ppppppp"),
    "dls_reduction_nodal": (c_int, "pppp"),
    "dls_reduction_move": (c_int, "pppp"),
    "dls_reduction_destroy": (None, "p"),
    "dls_pairs_find": (c_int, "ppp"),
    "dls_pairs_free": (None, "p"),
    "dls_rigid_contact": (c_int, "ipiippdippppp"),
    "dls_rigid_apply": (c_int, "ipipppp"),
    "dls_motion_create": (c_int, "pppp"),
    "dls_motion_start": (c_int, "pppdp"),
    "dls_limit_settings_init": (None, "p"),
    "dls_limit_load": (c_int, "ppppppppppp" "p"),
    "dls_motion_step": (c_int, "pppppp"),
    "dls_motion_set_h": (c_int, "pdp"),
    "dls_motion_get_state": (c_int, "ppp"),
    "dls_motion_get_energies": (c_int, "ppp"),
    "dls_motion_get_problem": (c_int, "ppp"),
    "dls_motion_destroy": (None, "p"),
}

for _name, (_result, _arguments) in _SIGNATURES.items():
    _function = getattr(lib, _name, None)
    if _function is None:
        raise ImportError(f"delassus: the library has no {_name}")
    _function.restype = _result
    _function.argtypes = [{"p": c_void_p, "s": c_char_p, "i": c_int, "d": c_double,
                           "z": c_size_t}[a] for a in _arguments]


# arguments of C that have another name in Python
_NAMES = {"Ks": "K", "Wb": "W", "Ms": "M", "bodies.body": "body", "bodies.H": "H"}


def _in_python(message: str) -> str:
    """Returns a message of the library without the name of the function in C, its argument by the
    name in Python."""
    head, _, text = message.partition(": ")
    if not head.startswith("dls_"):
        return message
    found = re.match(r"[A-Za-z_.]+", text)
    name = found.group(0) if found else ""
    start = name == "r" and head in ("dls_solve", "dls_reduction_solve", "dls_solver_solve")
    return ("r0" if start else _NAMES.get(name, name)) + text[len(name):]


def one_of(what: str, name: object, names: Iterable[str]) -> ValueError:
    """Returns the error of a name that is none of `names`, with the nearest one."""
    names = list(names)
    small = name.lower() if isinstance(name, str) else ""
    near = [n for n in names if n.lower() == small] or difflib.get_close_matches(small, names, 1, 0.6)
    meant = f"; did you mean {near[0]!r}?" if near else ""
    return ValueError(f"{what}: {name!r} is none of {', '.join(names)}{meant}")


class Error(Exception):
    """A status below 0: nothing was computed. status, name ("DLS_E_SIZE"), function, argument,
    index and value have the details. The classes below are raised; each is also one of Python's
    own errors."""

    status: int
    name: str
    function: str
    argument: str
    index: int
    value: float

    def __init__(self, error: Any) -> None:
        super().__init__(_in_python(error.message.decode(errors="replace")))
        self.status = error.status
        self.name = lib.dls_status_name(error.status).decode()
        self.function = ctypes.string_at(error.function).decode() if error.function else ""
        self.argument = ctypes.string_at(error.argument).decode() if error.argument else ""
        self.index = error.index
        self.value = error.value

    def __reduce__(self) -> Any:  # processes hand exceptions on by pickle
        return _restore, (type(self), self.args, self.__dict__)


class InputError(Error, ValueError):
    """An argument has a wrong value, size or kind."""


class OutOfMemoryError(Error, MemoryError):
    """There is no memory, or the estimate exceeds memory_limit."""


class SingularError(Error, np.linalg.LinAlgError):
    """K is singular, or not positive definite with Cholesky."""


class UnsupportedError(Error, NotImplementedError):
    """Not in this build, or not for this kind of problem."""


class StateError(Error, RuntimeError):
    """A callback failed, or another call is using the object."""


class NoDerivativeError(Error, ArithmeticError):
    """The solution has no derivative: a contact, `index`, is on the border of two states, or the
    reactions are not determined."""


_KINDS = {"DLS_E_NO_DERIVATIVE": NoDerivativeError, "DLS_E_MEMORY": OutOfMemoryError,
          "DLS_E_NOT_POSITIVE_DEFINITE": SingularError,
          "DLS_E_SINGULAR": SingularError, "DLS_E_UNSUPPORTED": UnsupportedError,
          "DLS_E_CALLBACK": StateError, "DLS_E_BUSY": StateError}


def error_of(error: Any, file: str = "") -> Error:
    """Returns the exception of a dls_error, about a file if one is named."""
    kind = _KINDS.get(lib.dls_status_name(error.status).decode(), InputError)
    made: Error = kind(error)
    if file and made.argument == "path":
        text = str(made).partition(": ")[2].replace("--triplets", "triplets=True")
        made.args = (f"{file}: {text}",)
    return made


def _restore(kind: type[Error], arguments: tuple[Any, ...], state: dict[str, Any]) -> Error:
    exception: Error = kind.__new__(kind, *arguments)
    exception.args = arguments
    exception.__dict__.update(state)
    return exception


class Owner:
    """Owns an object of the library, self._held, which has one owner."""

    _held: Any

    def __reduce_ex__(self, protocol: Any) -> NoReturn:
        raise TypeError(f"a {type(self).__name__} owns memory of the library: "
                        "it cannot be copied or pickled")


def call(name: str, *arguments: Any) -> int:
    """Calls a function whose last argument is dls_error *; raises Error for a status below 0, else
    returns it. Threads of Python run on meanwhile."""
    error = structs["dls_error"]()
    status: int = getattr(lib, name)(*arguments, byref(error))
    if status < 0:
        raise error_of(error)
    return status


# ---- callbacks -----------------------------------------------------------------------------------


def _rounds(count: int, function: Callable[..., Any],
            caught: list[BaseException]) -> Generator[int, Any, None]:
    """Takes values one by one; after `count` of them yields 1 if function(*values) is true or an
    exception was caught, which `caught` (a list) receives; 0 before."""
    values: list[Any] = []
    taken = answer = 0
    while True:
        try:
            # Python 3.11 looks one instruction before the target of a jump back for the try that
            # holds what a signal's handler raises there: this one
            answer += 0
            while True:
                taken += 1
                values.append((yield answer))
                answer = 0
                if taken == count:
                    answer = int(bool(caught or function(*values)))
                    values, taken = [], 0
        except GeneratorExit:
            return
        except BaseException as exception:  # of the function, or of the handler of a signal
            # without this frame: traceback.clear_frames, of unittest say, would end the generator
            trace = exception.__traceback__
            caught.append(exception.with_traceback(trace and trace.tb_next))
            answer = int(taken == count)
            if answer:
                values, taken = [], 0


class Callback:
    """A function of C with `kinds` of integers, the first of them 0, that runs a function of Python
    and returns 0; not 0 where that returned True or raised. `caught` holds what was raised.

    Python runs the handlers of signals (Ctrl-C) when it enters a function, where no try holds what
    they raise and C would never see it. So C enters no function of Python: it sends the integers,
    one by one, into a generator, which waits within its try. max() is the function of C that does:
    it returns its first argument, 0, unless a later one has a larger key. A second signal can end
    the generator while it keeps what the first one raised.
    """

    def __init__(self, function: Callable[..., Any], *kinds: Any) -> None:
        self.caught: list[BaseException] = []
        self._start = functools.partial(_rounds, len(kinds), function, self.caught)
        self._rounds = self._start()
        next(self._rounds)
        self._entry: Any = functools.partial(max, key=self._rounds.send)
        self._function = ctypes.CFUNCTYPE(c_int, *kinds)(self._entry)
        self.address = ctypes.cast(self._function, c_void_p).value

    def begin(self) -> None:
        del self.caught[:]
        if self._rounds.gi_frame is None:
            self._rounds = self._start()
            next(self._rounds)
            self._entry.keywords["key"] = self._rounds.send

    def end(self) -> None:
        """Raises what the last call caught."""
        if self.caught:
            raise self.caught[0]
        if self._rounds.gi_frame is None:
            raise KeyboardInterrupt


# ---- arrays --------------------------------------------------------------------------------------


def entries(a: npt.NDArray[Any]) -> str:
    """Returns the number of entries in words."""
    return f"{a.size} entry" if a.size == 1 else f"{a.size} entries"


def _check_kind(name: str, dtype: np.dtype[Any]) -> None:
    if dtype.kind not in "biuf":
        kind = {"c": "complex numbers", "O": "objects", "U": "text", "S": "text"}.get(dtype.kind)
        raise ValueError(f"{name} holds {kind or dtype}, must hold real numbers")


def reals(name: str, x: Any) -> Vector:
    """Returns x as an array of doubles; refuses complex numbers, objects, text and masks."""
    a = np.asarray(x)
    _check_kind(name, a.dtype)
    if isinstance(x, np.ma.MaskedArray) and np.any(x.mask):
        raise ValueError(f"{name} has masked entries")
    return np.asarray(a, dtype=np.float64)


def number(name: str, x: Any) -> float:
    """Returns a real number as a float."""
    a = reals(name, x)
    if a.ndim:
        raise ValueError(f"{name} is an array, must be a number")
    return float(a)


def whole(name: str, x: Any, least: int = -2**31, most: int = 2**31 - 1) -> int:
    """Returns an integer within the range of C's int, or a smaller one."""
    try:
        value = operator.index(x)
    except TypeError:
        raise ValueError(f"{name} is {x!r}, must be an integer") from None
    if not least <= value <= most:
        raise ValueError(f"{name} is {value}, must be from {least} to {most}")
    return value


def integers(name: str, x: Any) -> npt.NDArray[np.intc]:
    """Returns x as a contiguous array of C's int."""
    a = np.asarray(x)
    if a.size and a.dtype.kind not in "biu":
        raise ValueError(f"{name} holds {a.dtype}, must hold integers")
    if a.size and (a.min() < -2**31 or a.max() > 2**31 - 1):
        raise ValueError(f"{name} has an entry beyond 2^31")
    return np.ascontiguousarray(a, dtype=np.intc)


def vector(name: str, x: Any, size: int, width: int = 1) -> Vector:
    """Returns x as a contiguous array of `size` doubles: given flat, or in rows of `width`, or one
    number for all."""
    a = reals(name, x)
    if a.ndim == 0:
        return np.full(size, float(a))
    if a.size != size:
        raise ValueError(f"{name} has {entries(a)}, needs {size}")
    if a.ndim > 1 and a.shape[-1] != width and max(a.shape) != size:
        raise ValueError(f"{name} is {a.shape}, needs rows of {width}")
    return np.ascontiguousarray(a).reshape(-1)


def gaps(name: str, g: Any, nodes: int, d: int, width: int) -> Vector:
    """Returns d values for each of the nodes in rows of `width`, the others 0."""
    a = vector(name, g, nodes * d, d)
    if d < width:
        rows = np.zeros((nodes, width))
        rows[:, :d] = a.reshape(nodes, d)
        a = rows.reshape(-1)
    return a


def set_fields(struct: Any, values: Mapping[str, Any]) -> None:
    """Sets numbers of a struct by name; None leaves the default."""
    kinds = dict(struct._fields_)
    for name, value in values.items():
        if value is None:
            continue
        setattr(struct, name,
                whole(name, value) if kinds[name] is c_int else number(name, value))


def address(a: Any) -> Any:
    """Returns the address of an array, None (NULL) for None. The array has to outlive its use."""
    return None if a is None else a.ctypes.data


def dense(a: npt.NDArray[Any]) -> Any:
    """Returns a dls_dense of a Fortran-ordered array of doubles."""
    rows, cols = a.shape
    return structs["dls_dense"](rows, cols, max(1, rows), address(a))


def columns(name: str, a: Any) -> Any:
    """Returns scipy's compressed columns of a matrix with 32-bit indices."""
    import scipy.sparse

    if hasattr(a, "tocsc"):
        _check_kind(name, a.dtype)
    else:
        a = reals(name, a)
    c = scipy.sparse.csc_matrix(a, dtype=np.float64)
    if c.nnz > np.iinfo(np.int32).max:
        raise ValueError(f"{name} has more than 2^31 entries")
    c.indptr = np.ascontiguousarray(c.indptr, dtype=np.int32)
    c.indices = np.ascontiguousarray(c.indices, dtype=np.int32)
    return c


def sparse(c: Any) -> Any:
    """Returns a dls_sparse of compressed columns; zero for None."""
    if c is None:
        return structs["dls_sparse"]()
    return structs["dls_sparse"](*c.shape, address(c.indptr), address(c.indices), address(c.data))


def read(kind: Any, pointer: int | None, size: int, owner: object) -> npt.NDArray[Any]:
    """Returns a read-only array over memory of the library, which `owner` keeps alive."""
    if not size or not pointer:
        return np.zeros(0, dtype=np.dtype(kind))
    memory = (kind * size).from_address(pointer)
    memory.owner = owner
    a = np.frombuffer(memory, dtype=np.dtype(kind))
    a.flags.writeable = False
    return a
