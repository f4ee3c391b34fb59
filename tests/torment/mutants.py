#!/usr/bin/env python3
"""mutants.py BUILD [--count N] [--seed S] [--file PATH] [--seconds N]: shows which code no test watches.

Changes one operator, index, sign or factor at a random place of the product, rebuilds its object and
the program of all tests, and runs those that enter its function (measured once, at first) until one
fails: first those that have killed most mutants a second. Each ends at its first failure. A mutant
that passes them all, or --seconds of CPU of them, runs once more with its file under the address and
undefined sanitizers. One that passes there, too, has survived: its line wants a test, or an entry in
harmless.txt that says why the change does no harm. All happens in a copy of the tree, so that a run
that is cut off leaves nothing behind.

Not counted: what does not compile, and what compiles to the same code. A test that fails without a
mutant, too, or takes a minute, is left out and named. Exit status 1 if more than one mutant in twenty
has survived.
"""
import argparse
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

PROGRAM_ROOMS = ("src/console", "src/problem", "src/charts", "src/report", "src/cli")
ROOMS = ["lcp", "vi", "reduction", "global", "src/base", "src/contact", "src/geometry", "src/linear",
         "src/files", "src/facts", "src/auto", "src/front", "src/motion", "src/fe", *PROGRAM_ROOMS]
PROGRAM_OBJECTS = tuple("build/obj/" + room for room in PROGRAM_ROOMS)
# Random problems, solved in many ways and certified, which see every method and both rooms of LCP.
PROPERTIES = "properties/properties --class each --seed 1 --step 2 --count 60 --out properties"
# What tests are linked with beside the library and tests/shared, as in the Makefile.
JUDGES = [str(p)[:-2] for p in pathlib.Path("tests/properties").glob("*.c")
          if p.name != "properties.c" and not p.name.startswith("test_")]
OTHERS = {"properties/properties": JUDGES, "properties/test_judges": JUDGES,
          "front/test_measure": ["bench/common", "bench/solvers_call"],
          "cli/test_budget": ["src/report/report_budget"]}
ALL = "build/tests/all"  # the program of all tests
PROGRAM = "build/delassus"
LIBRARIES = ("build/libdelassus.a", "build/libdelassus-files.a", "build/libdelassus-fe.a")
REACH = "build/reach/"  # the same, each function of which tells reach.c that it is entered
MEMORY = "build/obj/src/base/memory.o"
RUN = "build/obj/tests/shared/run.o"  # the list of a program's tests, and its main
NOBODY = 65534
CPU_SECONDS = 60  # of one test program
FIRST_SECONDS, LONG = 20, 40  # of the run that shows which functions a test enters; of a test that takes longer, a guess
QUICK = 3  # seconds of a test of the library that runs under the sanitizers, too
# Of the mutated file alone, for what only reads or writes where it should not.
SANITIZERS = "-fsanitize=address,undefined -fno-sanitize-recover=all"
UNDER = ", under the sanitizers"
SWAP = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "&&": "||", "||": "&&",
        "+": "-", "-": "+", "*": "/", "/": "*", "+=": "-=", "-=": "+=", "*=": "/=", "/=": "*="}


def code_of(text):
    """Returns text with blanks for comments, strings and preprocessor lines, of the same length."""
    pattern = r'/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\'|^[ \t]*#(?:\\\n|[^\n])*'
    blank = lambda m: re.sub(r"[^\n]", " ", m.group())
    return re.sub(pattern, blank, text, flags=re.S | re.M)


def is_declared(before):
    """Returns 1 if the [ that follows `before` on its line gives an array its size."""
    types = r"(?:double|float|char|int|long|size_t|int64_t|uint64_t|[a-z]+_[a-z_]+)"
    return bool(re.search(r"\b%s (?:const )?\**\w+(?:\[[^\]]*\])*$" % types, before)
                or re.match(r"\s*(?:static |const |enum )*%s [^=(]*$" % types, before))


def factor_of(number, before, after):
    """Returns what replaces a number between two texts: the next one, or twice the number. A 1 or -1
    that is a whole value becomes 0, since of a flag 2 is as true as 1, and -2 as negative as -1."""
    if number == "1" and re.search(r"(?:\breturn |[^=!<>]= |[(,?:] |[({])-?$", before):
        if re.match(r"\s*[;,):}]", after):
            return "0"
    return str(int(number) + 1) if number.isdecimal() else "2 * " + number


def places_of(path, text):
    """Returns all (path, begin, end, replacement, kind) of a file."""
    code, places = code_of(text), []

    def add(begin, end, new, kind):
        places.append((path, begin, end, new, kind))

    for m in re.finditer(r"(?<= )(<=|>=|==|!=|&&|\|\||[-+*/]=|[-+*/<>])(?=[ \n])", code):
        add(m.start(), m.end(), SWAP[m.group()], "operator")
    for m in re.finditer(r"(?<=\w)\[([^\[\]]+)\]", code):
        before = code[code.rfind("\n", 0, m.start()) + 1:m.start()]
        if not is_declared(before):
            add(m.start(1), m.end(1), "(%s) + 1" % text[m.start(1):m.end(1)], "index")
    for m in re.finditer(r"(?<=[(=,?:] )-(?=[\w(])|(?<=[(\[])-(?=[\w(])|(?<=return )-(?=[\w(])", code):
        add(m.start(), m.end(), "", "sign")
    for m in re.finditer(r"\bfabs(?=\()", code):
        add(m.start(), m.end(), "", "sign")
    number = r"(?<![\w.])(?:0x[0-9a-f.]+p[-+]?\d+|\d+\.?\d*(?:e[-+]?\d+)?|\.\d+(?:e[-+]?\d+)?)(?![\w.])"
    for m in re.finditer(number, code):
        before = code[code.rfind("\n", 0, m.start()) + 1:m.start()]
        if before.endswith("[") and is_declared(before[:-1]):
            continue
        if re.search(r"\bd[a-z0-9]+_\(", before) and re.match(r"(, \d)*\)", code[m.end():m.end() + 9]):
            continue  # of LAPACK: the hidden length of a letter, which nobody reads
        add(m.start(), m.end(), factor_of(m.group(), before, code[m.end():m.end() + 99]), "factor")
    return places


def line_at(text, at):
    """Returns the number of the line at an offset, and its words, single-spaced."""
    begin, end = text.rfind("\n", 0, at) + 1, text.find("\n", at)
    return text.count("\n", 0, at) + 1, " ".join(text[begin:end].split())


def function_at(text, at):
    """Returns the name of the function that an offset lies in, "" before the first one."""
    names = re.findall(r"^[a-z][^;={}]*?\b(\w+)\((?=[^;{}]*\{$)", code_of(text)[:at], flags=re.M)
    return names[-1] if names else ""


def read_harmless(path):
    """Returns {(place, mutated line): reason} of harmless.txt: file:function | line | reason."""
    known = {}
    for line in path.read_text().splitlines():
        if line.strip() and not line.startswith("#"):
            place, rest = line.split(" | ", 1)
            mutated, reason = rest.rsplit(" | ", 1)
            known[place.strip(), " ".join(mutated.split())] = reason.strip()
    return known


class Tree:
    """A copy of the tree, in which one file at a time differs."""

    def __init__(self, build):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="delassus-mutants-"))
        self.root.chmod(0o777)  # for tests that write beside themselves
        self.build = "build"
        for name in subprocess.check_output(["git", "ls-files"], text=True).splitlines():
            if os.path.exists(name):
                (self.root / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(name, self.root / name)
        if os.path.isdir(build):  # spares the first build; make makes up what is missing
            keep = lambda d, names: [n for n in names if d == build and n in ("asan", "tsan", "coverage")]
            shutil.copytree(build, self.root / "build", symlinks=True, ignore=keep)
        self.env = dict(os.environ, OPENBLAS_NUM_THREADS="1", CK_FORK="no", DELASSUS_PROGRAM=PROGRAM, MAKEFLAGS="")
        self.seconds, self.reached = {}, {}  # of each test: CPU, and the functions that it enters, "file:function"
        self.tried, self.kills = {}, {}  # of each test: mutants that it saw, and stopped
        self.false = []  # what fails without a mutant
        # PREFIX_MAP: a compiler's cache is of use in any folder
        self.ours = ["PREFIX_MAP=", *(["LDFLAGS=-fuse-ld=gold"] if shutil.which("ld.gold") else [])]

    def gather(self, tests):
        """Makes all tests one program, so that a mutant is linked once: its first argument is the test."""
        parts, self.tests = self.root / "gathered", tests
        parts.mkdir()
        run = lambda *command: subprocess.run(command, cwd=self.root, check=True)
        table = [(test.split()[0], self.part(k)) for k, test in enumerate(tests)]
        count = range(len(tests))
        (parts / "main.c").write_text("#include <string.h>\n"
            + "#include <unistd.h>\n"
            + "_Noreturn void __wrap__ck_assert_failed(void);\n"
            + "void __wrap__ck_assert_failed(void) { _exit(1); }\n"
            + "".join("int main%d(int, char **);\n" % k for k in count)
            + "int main(int argc, char **argv) {\n"
            + "".join('  if (strcmp(argv[1], "%s") == 0) return main%d(argc - 1, argv + 1);\n'
                      % (table[k][0], k) for k in count) + "  return 99;\n}\n")
        run("cc", "-c", "-o", parts / "main.o", parts / "main.c")
        one = "build/tests/" + tests[0].split()[0]
        own = "build/obj/tests/%s.o" % tests[0]
        self.link = [w for old in self.line_of(one, "tests/%s.c" % tests[0]).split() for w in
                     ([str(parts / "main.o"), *(str(part) for _, part in table)] if old == own
                      else [ALL if old == one else old])] + ["-Wl,--wrap=_ck_assert_failed"]
        said = subprocess.check_output(["make", "-n", "-B", "V=1", *self.ours, *LIBRARIES, PROGRAM], cwd=self.root,
                                       env=self.env, text=True)
        self.compiler = {line.split(" -c -o ")[1].split()[0]: line + " -g0"  # of each object
                         for line in said.splitlines() if " -c -o " in line}
        self.link_program = self.line_of(PROGRAM, "src/cli/main.c").split()
        self.program_tests = {t for t in tests
                              if "program.h" in (self.root / ("tests/%s.c" % t.split()[0])).read_text()}

    def part(self, k):
        """Makes test k one object with its list of tests, the main of which has a name of its own; returns its path."""
        name, part = self.tests[k].split()[0], self.root / ("gathered/part%d.o" % k)
        own = ["build/obj/tests/%s.o" % name, RUN, *("build/obj/%s.o" % other for other in OTHERS.get(name, []))]
        subprocess.run(["ld", "-r", "-S", "-o", part, *own], cwd=self.root, check=True)
        subprocess.run(["objcopy", "--redefine-sym", "main=main%d" % k, "--keep-global-symbol=main%d" % k, part],
                       cwd=self.root, check=True)
        return part

    def parts_with(self, file):
        """Makes the tests anew that hold the object of a file of the product."""
        for k, test in enumerate(self.tests):
            if file[:-2] in OTHERS.get(test.split()[0], []):
                self.part(k)

    def line_of(self, goal, changed):
        """Returns the command by which make would make `goal` anew."""
        said = subprocess.check_output(["make", "-n", "V=1", "-W", changed, *self.ours, goal], cwd=self.root,
                                       env=self.env, text=True)
        return next(l for l in said.splitlines() if " -o %s " % goal in l + " ")

    def measure(self, tests):
        """Runs each test once without a mutant: sets seconds and reached, and leaves out what fails."""
        built, said = self.make("BUILD=" + REACH[:-1], "HARDEN=", "CFLAGS=-O1 -g1 -finstrument-functions",
                                *(name.replace("build/", REACH) for name in (*LIBRARIES, PROGRAM)))
        line = [REACH + w[6:] if w in (*LIBRARIES, ALL) else w for w in self.link]
        (self.root / (REACH + "tests")).mkdir(parents=True)
        load = ["cc", "-O2", "-shared", "-fPIC", "-o", REACH + "reach.so", "tests/torment/reach.c"]
        if not built or any(subprocess.run(command, cwd=self.root).returncode for command in (load, line)):
            sys.exit("the tree does not build:\n" + said)
        self.bind(self.link)
        names = {}
        for test in tests:
            before, entered = cpu(), self.root / ("entered-%s" % test.split()[0].replace("/", "-"))
            passes = self.run(test, REACH, {"REACH": str(entered), "LD_PRELOAD": str(self.root / (REACH + "reach.so"))},
                              FIRST_SECONDS)
            self.seconds[test] = cpu() - before
            if self.seconds[test] > 0.9 * FIRST_SECONDS:  # stopped there
                self.seconds[test] = LONG
            elif not passes and not self.run(test):
                self.false.append(test)
                continue
            self.reached[test] = set()
            for program in (ALL, PROGRAM):
                path = pathlib.Path("%s.%s" % (entered, os.path.basename(program)))
                if path.exists():
                    self.reached[test] |= self.names_of(REACH + program[6:], path.read_bytes(), names)
                    path.unlink()

    def names_of(self, program, table, names):
        """Returns "file:function" and "file:" of the addresses in reach.c's table."""
        places = [(program, at) for at in {x for x, in struct.iter_unpack("=Q", table)} - {0}]
        new = [at for _, at in places if (program, at) not in names]
        said = subprocess.run(["addr2line", "-f", "-e", program], cwd=self.root, text=True, stdout=subprocess.PIPE,
                              input="".join("%x\n" % at for at in new)).stdout.split("\n")
        for k, at in enumerate(new):
            file = re.search(r"(?:^|/)((?:%s)/[\w/]+\.c):" % "|".join(ROOMS), said[2 * k + 1])
            names[program, at] = {file[1] + ":" + said[2 * k], file[1] + ":"} if file else set()
        return set().union(*(names[place] for place in places))

    def tests_of(self, file, function):
        """Returns the tests that enter a function, or where that is not known its file; the sharpest first."""
        of = lambda place: [t for t in self.reached if place in self.reached[t]]
        worth = lambda t: self.seconds[t] * (1 + self.tried.get(t, 0)) / (1 + self.kills.get(t, 0))
        inside = [t for t in self.reached if file[:-2] in OTHERS.get(t.split()[0], [])]
        return sorted({*(of(file + ":" + function) or of(file + ":")), *inside}, key=worth)

    def bind(self, line, *objects, flags=()):
        """Links a program, with these objects in place of those in the archives."""
        first = next(k for k, word in enumerate(line) if word.endswith(".a"))
        new = [word for word in objects if word not in line]
        return subprocess.run([*line[:first], *new, *line[first:], *flags, "-Wl,-S"], cwd=self.root,
                              stderr=subprocess.DEVNULL).returncode == 0

    def bind_sanitized(self, object_file):
        """Links the program of all tests, or delassus with an object of its own, that object under the
        sanitizers; and the one that divides workspaces into arrays, which tells them what lies between
        these."""
        spared = (self.root / MEMORY).read_bytes()
        objects = {object_file, MEMORY}
        for name in objects:
            (self.root / name).unlink()
        built, _ = self.make(*objects, "CFLAGS=-O1 -g", "SANITIZE=" + SANITIZERS)
        line = self.link_program if object_file.startswith(PROGRAM_OBJECTS) else self.link
        bound = built and self.bind(line, *objects, flags=SANITIZERS.split())
        if object_file != MEMORY:
            (self.root / MEMORY).write_bytes(spared)
        return bound

    def make(self, *goals):
        done = subprocess.run(["make", "-s", "-k", *self.ours, *goals], cwd=self.root, env=self.env,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        return done.returncode == 0, done.stdout

    def code(self, object_file):
        """Returns the object without the tables for a debugger, which know lines and columns."""
        stripped = self.root / "stripped.o"
        subprocess.run(["strip", "-g", "-o", stripped, self.root / object_file], check=True)
        return stripped.read_bytes()

    def run(self, test, build="build/", more={}, seconds=CPU_SECONDS):
        """Runs a test with limits of time and memory, and never as root, as whom a mutant may replace
        a device by a file. Returns 1 if it passes."""

        def confine():
            if os.geteuid() == 0:
                os.setgroups([])
                os.setgid(NOBODY)
                os.setuid(NOBODY)
            resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
            if not more:  # sanitizers reserve all addresses
                resource.setrlimit(resource.RLIMIT_AS, (1 << 33, 1 << 33))
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

        null = subprocess.DEVNULL
        program = {"DELASSUS_PROGRAM": build + "delassus"}
        process = subprocess.Popen([build + "tests/all", *test.split()], cwd=self.root,
                                   env={**self.env, **program, **more}, stdin=null, stdout=null, stderr=null,
                                   start_new_session=True, preexec_fn=confine)
        try:
            return process.wait(timeout=20 * CPU_SECONDS) == 0
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            return False


def cpu():
    """Returns the seconds of CPU of all that has run."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def try_sanitized(tree, source, text, object_file, tests, until):
    """Returns a test that the sanitizers stop on the mutant, but not on `text`, "" for none."""
    sanitized = {"ASAN_OPTIONS": ""}
    if not tree.bind_sanitized(object_file):
        return ""
    stopped = next((test for test in tests if cpu() < until and not tree.run(test, more=sanitized)), "")
    source.write_text(text)
    if not stopped or not tree.bind_sanitized(object_file) or not tree.run(stopped, more=sanitized):
        return ""
    return stopped + UNDER


def try_mutant(tree, place, function, seconds):
    """Returns what became of the mutant: a test that kills it, "" for none, None for no mutant."""
    path, begin, end, new, _ = place
    source = tree.root / path
    text = source.read_text()
    object_file = "build/obj/" + path[:-2] + ".o"
    before = tree.code(object_file)
    spared = (tree.root / object_file).read_bytes()
    try:
        source.write_text(text[:begin] + new + text[end:])
        built = subprocess.run(tree.compiler[object_file], shell=True, cwd=tree.root, env=tree.env, stderr=subprocess.DEVNULL)
        if built.returncode or tree.code(object_file) == before:
            return None
        ordered = tree.tests_of(path, function)
        tree.parts_with(path)
        tree.bind(tree.link, *([] if path.startswith(PROGRAM_ROOMS) else [object_file]))
        has_program, until = False, cpu() + seconds
        for test in ordered:
            if cpu() > until:
                break
            if test in tree.program_tests and not has_program:
                has_program = tree.bind(tree.link_program, object_file)
            tree.tried[test] = tree.tried.get(test, 0) + 1
            if not tree.run(test):
                tree.kills[test] = tree.kills.get(test, 0) + 1
                return test
        quick = [t for t in ordered if tree.seconds[t] < QUICK or path.startswith(PROGRAM_ROOMS)]
        return try_sanitized(tree, source, text, object_file, quick, cpu() + seconds)
    finally:
        source.write_text(text)
        (tree.root / object_file).write_bytes(spared)
        tree.parts_with(path)


def main():
    ask = argparse.ArgumentParser()
    ask.add_argument("build")
    ask.add_argument("--count", type=int, default=100)
    ask.add_argument("--seed", type=int, default=int(time.time()))
    ask.add_argument("--file", default="", help="mutants of files whose path begins so, alone")
    ask.add_argument("--seconds", type=int, default=120, help="CPU of the tests of one mutant")
    own = ask.parse_args()
    harmless = read_harmless(pathlib.Path("tests/torment/harmless.txt"))
    print("seed %d" % own.seed, flush=True)
    tree = Tree(own.build)
    try:
        tests = sorted(str(p)[6:-2] for p in pathlib.Path("tests").glob("*/test_*.c"))
        tests = [t for t in tests if not t.startswith("mpi/")] + [PROPERTIES]
        names = [t.split()[0] for t in tests]
        objects = ["tests/" + name for name in names] + [other for name in names for other in OTHERS.get(name, [])]
        built, said = tree.make(*LIBRARIES, PROGRAM, "build/tests/" + names[0], *("build/obj/%s.o" % name for name in objects))
        if not built:
            sys.exit("the tree does not build:\n" + said)
        tree.gather(tests)
        tree.measure(tests)
        for test in tree.false:
            print("left out, fails without a mutant, too: " + test, flush=True)
        places = []
        for room in ROOMS:
            for path in sorted(pathlib.Path(room).rglob("*.c")):
                if str(path).startswith(own.file) and os.path.exists(tree.root / "build/obj" / path.with_suffix(".o")):
                    places += places_of(str(path), path.read_text())
        random.Random(own.seed).shuffle(places)
        count = {"killed": 0, "harmless": 0, "SURVIVED": 0}
        for place in places:
            if sum(count.values()) >= own.count:
                break
            path, begin, end, new, kind = place
            text = (tree.root / path).read_text()
            number, old = line_at(text, begin)
            _, mutated = line_at(text[:begin] + new + text[end:], begin)
            function = function_at(text, begin)
            reason = harmless.get(("%s:%s" % (path, function), mutated))
            if reason:
                what, by = "harmless", reason
            else:
                by = try_mutant(tree, place, function, own.seconds)
                if by is None:
                    continue
                what = "killed" if by else "SURVIVED"
            count[what] += 1
            print("%-8s %s:%d %s: %s%s" % (what, path, number, kind, mutated,
                  "  <-  " + old if what == "SURVIVED" else "  [%s]" % by), flush=True)
        total = sum(count.values())
        print("seed %d: of %d mutants %d killed, %d harmless, %d survived"
              % (own.seed, total, count["killed"], count["harmless"], count["SURVIVED"]))
        return count["SURVIVED"] * 20 > total
    finally:
        shutil.rmtree(tree.root, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
