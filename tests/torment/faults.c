/*
 * faults.c: runs commands of `delassus`, and the C interface, with the k-th call of one kind
 * failing: malloc, open, fdopen, fsync, rename, close; or with files limited to so many bytes, as
 * on a full disk; or with a full standard output. Each run is a process of its own, in a directory
 * that already has an old version of every file that the command writes.
 *
 *   faults [--most=K] [CASE]...      K runs of a kind, evenly spread; 0: each one
 *
 * A run is good if it ends by itself, with status 2 and one line on stderr, or with all that a run
 * without failures prints and writes; if every file is the old one or a whole new one; if no
 * temporary file is left; and if it has freed what a run without failures frees.
 *
 * Only calls of our own objects pass through here (ld --wrap), not those inside of libraries.
 */
#define _GNU_SOURCE
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "delassus.h"

int delassus_main(int argc, char **argv); /* main of src/cli/main.c */

/* ---- calls that fail ------------------------------------------------------------------------- */

typedef enum kind {
  MALLOC,
  READ, /* opening to read */
  OPEN, /* opening to write */
  FDOPEN,
  FSYNC,
  RENAME,
  CLOSE, /* of what was written */
  BYTES,
  STDOUT,
  KINDS
} kind;
static const char *const kind_names[KINDS] = {"malloc", "read",  "open",  "fdopen", "fsync",
                                              "rename", "close", "bytes", "stdout"};

enum { table_size = 1 << 20 };

/* What parent and child share. */
typedef struct shared {
  long calls[KINDS];
  long live; /* blocks that were not freed */
} shared;

static shared *seen;
static kind failing = KINDS;
static long failing_at;
static void *table[table_size]; /* blocks in use */
static int counting;

/* Counts a call of this kind; returns 1 if it is to fail. */
static int fails(kind what) {
  if (!counting) return 0;
  return ++seen->calls[what] == failing_at && failing == what;
}

static size_t find_block(const void *block) {
  size_t k = ((uintptr_t)block >> 4) * 2654435761u % table_size;
  while (table[k] && table[k] != block)
    k = (k + 1) % table_size;
  return k;
}

static void *note_block(void *block) {
  if (counting && block) {
    table[find_block(block)] = block;
    seen->live++;
  }
  return block;
}

/* Forgets a block; keeps the chains of the table whole. */
static void drop_block(const void *block) {
  if (!block) return;
  size_t k = find_block(block);
  if (!table[k]) return; /* of a library */
  seen->live--;
  table[k] = NULL;
  for (k = (k + 1) % table_size; table[k]; k = (k + 1) % table_size) {
    void *moved = table[k];
    table[k] = NULL;
    table[find_block(moved)] = moved;
  }
}

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void __real_free(void *block);
FILE *__real_fopen(const char *path, const char *mode);
FILE *__real_fdopen(int fd, const char *mode);
int __real_open(const char *path, int flags, ...);
int __real_fsync(int fd);
int __real_rename(const char *from, const char *to);
int __real_fclose(FILE *file);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);
void __wrap_free(void *block);
FILE *__wrap_fopen(const char *path, const char *mode);
FILE *__wrap_fdopen(int fd, const char *mode);
int __wrap_open(const char *path, int flags, ...);
int __wrap_fsync(int fd);
int __wrap_rename(const char *from, const char *to);
int __wrap_fclose(FILE *file);

#if WITH_MUMPS
void __real_dlsi_dmumps(void *mumps);
void __wrap_dlsi_dmumps(void *mumps);

void __wrap_dlsi_dmumps(void *mumps) {
  const int before = counting;
  counting = 0;
  __real_dlsi_dmumps(mumps);
  counting = before;
}
#endif

void *__wrap_malloc(size_t size) {
  return fails(MALLOC) ? NULL : note_block(__real_malloc(size));
}

void *__wrap_calloc(size_t count, size_t size) {
  return fails(MALLOC) ? NULL : note_block(__real_calloc(count, size));
}

void *__wrap_realloc(void *old, size_t size) {
  if (fails(MALLOC)) return NULL;
  drop_block(old);
  return note_block(__real_realloc(old, size));
}

void __wrap_free(void *block) {
  drop_block(block);
  __real_free(block);
}

FILE *__wrap_fopen(const char *path, const char *mode) {
  return fails(*mode == 'r' ? READ : OPEN) ? (errno = EMFILE, NULL) : __real_fopen(path, mode);
}

int __wrap_open(const char *path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const unsigned mode = flags & O_CREAT ? va_arg(more, unsigned) : 0;
  va_end(more);
  return fails(OPEN) ? (errno = ENOSPC, -1) : __real_open(path, flags, mode);
}

FILE *__wrap_fdopen(int fd, const char *mode) {
  return fails(FDOPEN) ? (errno = ENOMEM, NULL) : __real_fdopen(fd, mode);
}

int __wrap_fsync(int fd) {
  return fails(FSYNC) ? (errno = EIO, -1) : __real_fsync(fd);
}

int __wrap_rename(const char *from, const char *to) {
  return fails(RENAME) ? (errno = EXDEV, -1) : __real_rename(from, to);
}

/* Closes, and says that it failed, as a network's file system may. */
int __wrap_fclose(FILE *file) {
  const int written = (fcntl(fileno(file), F_GETFL) & O_ACCMODE) != O_RDONLY;
  const int failed = written && fails(CLOSE), result = __real_fclose(file);
  return failed ? (errno = EDQUOT, EOF) : result;
}

/* ---- cases ----------------------------------------------------------------------------------- */

/* Divides by 4: a host's own factorisation. */
static int quarter(void *user, double *X, int n, int nrhs) {
  (void)user;
  for (int k = 0; k < n * nrhs; k++)
    X[k] /= 4;
  return 0;
}

/* Reduces by the host's callback, solves and writes: the C interface without the program. */
static int run_callback(void) {
  const int i[] = {0, 1}, one[] = {0, 1};
  const double x[] = {1, 1}, f[] = {-1, .5}, mu[] = {.3};
  double r[2], u[2];
  const dls_model model = {.d = 2,
                           .n = 2,
                           .nodes = 1,
                           .operator_kind = DLS_HOST_SOLVER,
                           .factorization = DLS_CHOLESKY,
                           .solve = quarter,
                           .HN = {2, 1, one, i, x},
                           .HT = {2, 1, one, i + 1, x}};
  dls_reduction *reduction;
  dls_contact problem;
  dls_error error = {0};
  dls_status status = dls_reduction_create(&reduction, &model, NULL, &error);
  if (!status) status = dls_reduction_load(reduction, f, NULL, &error);
  if (!status) status = dls_reduction_contact(reduction, mu, &problem, &error);
  if (!status) status = dls_solve(&problem, NULL, r, u, NULL, &error);
  if (!status) status = dls_fclib_write_local("out.hdf5", &problem, "", r, u, &error);
  if (!status) status = dls_mtx_write("r.mtx", &(dls_dense){2, 1, 2, r}, &error);
  dls_reduction_destroy(reduction);
  if (status < 0) (void)fprintf(stderr, "delassus: %s\n", error.message);
  return status < 0 ? 2 : 0;
}

typedef struct fault_case {
  const char *name, *line; /* line: NULL for run_callback */
} fault_case;

static const fault_case cases[] = {
    {"callback", NULL},
    {"local", "solve local.hdf5 -o local.hdf5 --print"},
    {"global", "solve global.hdf5 -o out.hdf5 --csv csv -q"},
    {"text", "solve text.txt -o r.mtx --history h.csv"},
    {"plot", "solve text.txt --plot plot -m newton -j"},
    {"sparse",
     "solve --stiffness=job.sti --nodes=nodes.txt --f=f.txt --mu=0.3 --csv csv -o out.hdf5"},
    {"dense", "solve --flexibility=C.npy --HN=N.mtx --HT=T.mtx --f=f.txt --mu=mu.txt -o out.hdf5"},
    {"lcp", "solve --lcp M.mtx q.mtx -o z.mtx"},
    {"info", "info text.txt"},
    {"scene", "scene jean-fig3 --mesh 4x4 --weighted --out d --save out.hdf5"},
    {"forming", "scene indentation --mesh 6x4 --steps 2 --out d --save out.hdf5"},
    {"moving", "scene jean-moving --mesh 16x8 --steps 2 --out d"},
    {"bar", "scene bar-impact --mesh 6x1 --steps 6 --out d"},
    {"chart", "chart text.txt --repeat 1 --out d"},
    {"map", "map text.txt --rows 2 --out d"},
    {"profile", "profile text.txt --repeat 1 --out d"},
    {NULL, NULL}};

static int run_line(const char *line) {
  char copy[300], *argv[30] = {(char[]){"delassus"}};
  int argc = 1;
  (void)snprintf(copy, sizeof copy, "%s", line);
  for (char *word = strtok(copy, " "); word; word = strtok(NULL, " "))
    argv[argc++] = word;
  return delassus_main(argc, argv);
}

/* ---- directories ----------------------------------------------------------------------------- */

static char home[400], scratch[] = "/dev/shm/delassus-faults-XXXXXX";
static const char old_text[] = "an old file\n";

static int remove_one(const char *path, const struct stat *entry, int flag, struct FTW *where) {
  (void)entry, (void)flag, (void)where;
  return remove(path);
}

static void remove_tree(const char *path) {
  (void)nftw(path, remove_one, 8, FTW_DEPTH | FTW_PHYS);
}

static void die(const char *text) {
  (void)fprintf(stderr, "faults: %s\n", text);
  exit(2);
}

static char *read_whole(const char *path, size_t *size) {
  FILE *file = fopen(path, "rb");
  static char room[1 << 20];
  if (!file) return NULL;
  *size = fread(room, 1, sizeof room - 1, file);
  room[*size] = '\0';
  (void)fclose(file);
  char *copy = malloc(*size + 1);
  if (copy) memcpy(copy, room, *size + 1);
  return copy;
}

static void write_whole(const char *path, const char *text, size_t size) {
  FILE *file = fopen(path, "wb");
  if (!file || fwrite(text, 1, size, file) != size || fclose(file)) die(path);
}

static void copy_input(const char *from, const char *to) {
  char path[600];
  size_t size;
  (void)snprintf(path, sizeof path, "%s/data/%s", home, from);
  char *text = read_whole(path, &size);
  if (!text) die(path);
  write_whole(to, text, size);
  free(text);
}

#define WRITE(path, text) write_whole(path, text, strlen(text))

/* Fills the present directory with the inputs of all cases. */
static void write_inputs(void) {
  copy_input("fclib/FC3D_Example1.hdf5", "local.hdf5");
  copy_input("fclib/GFC3D_Example0.hdf5", "global.hdf5");
  copy_input("failures/c01-three-solutions.txt", "text.txt");
  copy_input("torment/job.sti", "job.sti");
  WRITE("job.dof", "1.1\n1.2\n2.1\n");
  WRITE("nodes.txt", "1 0 1\n");
  WRITE("f.txt", "0\n-1\n0.5\n");
  WRITE("mu.txt", "0.3\n");
  WRITE("N.mtx", "%%MatrixMarket matrix array real general\n3 1\n0\n1\n0\n");
  WRITE("T.mtx", "%%MatrixMarket matrix coordinate real general\n3 1 1\n1 1 1\n");
  WRITE("M.mtx", "%%MatrixMarket matrix array real general\n2 2\n2\n1\n1\n2\n");
  WRITE("q.mtx", "%%MatrixMarket matrix array real general\n2 1\n-1\n-2\n");
  char head[128] = "\x93NUMPY\x01";
  const double C[] = {4, 1, 0, 1, 4, 1, 0, 1, 4};
  char npy[200];
  memset(head + 8, ' ', 120);
  head[8] = 118;
  head[9] = 0;
  (void)memcpy(head + 10, "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 3), }", 59);
  head[127] = '\n';
  memcpy(npy, head, 128);
  memcpy(npy + 128, C, sizeof C);
  write_whole("C.npy", npy, 200);
}

/* A file that a command has written without failures. */
typedef struct product {
  char path[200];
  char *text;
  size_t size;
} product;

enum { most_products = 200 };
static product products[most_products];
static int product_count;
static product inputs[64];
static int input_count;

static const product *find_input(const char *path) {
  for (int k = 0; k < input_count; k++)
    if (!strcmp(inputs[k].path, path)) return &inputs[k];
  return NULL;
}

static int note_product(const char *path, const struct stat *entry, int flag, struct FTW *where) {
  (void)entry, (void)where;
  path += 2; /* "./" */
  if (flag != FTW_F) return 0;
  if (product_count == most_products) die("too many files");
  product *p = &products[product_count];
  (void)snprintf(p->path, sizeof p->path, "%s", path);
  p->text = read_whole(path, &p->size);
  product_count++;
  return 0;
}

static int note_input(const char *path, const struct stat *entry, int flag, struct FTW *where) {
  (void)entry, (void)where;
  if (flag != FTW_F) return 0;
  product *p = &inputs[input_count++];
  (void)snprintf(p->path, sizeof p->path, "%s", path + 2);
  p->text = read_whole(path, &p->size);
  return 0;
}

static int is_same(const product *p, const char *text, size_t size) {
  return size == p->size && memcmp(text, p->text, size) == 0;
}

/* Returns 1 for a table that grows with its run, and keeps its rows whatever ends that. */
static int grows(const char *path) {
  static const char *const names[] = {"force.csv", "contact.csv", "energy.csv", "map.csv",
                                      "map.dat",   "bar.dat",     "loop.dat",   "profile.csv"};
  for (size_t k = 0; k < sizeof names / sizeof *names; k++)
    if (strstr(path, names[k])) return 1;
  return 0;
}

/* Returns 1 if the text is whole beside that of a run without failures: the bytes are, or the
 * number of lines, because seconds of CPU differ. */
static int is_whole(const product *p, const char *text, size_t size) {
  if (is_same(p, text, size)) return 1;
  /* a collection grows as a run goes on, and is whole after each step */
  const char *end = strstr(p->path, ".pvd") ? strstr(text, "</VTKFile>\n") : NULL;
  size_t lines[2] = {0, 0};
  for (size_t k = 0; k < size; k++)
    lines[0] += text[k] == '\n';
  for (size_t k = 0; k < p->size; k++)
    lines[1] += p->text[k] == '\n';
  if (end) return !end[11];
  /* a script closes its loop last; what is slow this time has a line of its own in it */
  if (strstr(p->path, ".gp")) return size > 2 && strcmp(text + size - 3, "\n}\n") == 0;
  const int head = (int)strcspn(p->text, "\n");
  if (grows(p->path) && lines[0] > 1 && lines[0] < lines[1] && !memcmp(text, p->text, (size_t)head))
    lines[0] = lines[1];
  return size && text[size - 1] == '\n' && lines[0] == lines[1];
}

static int temporaries;
static int count_temporary(const char *path, const struct stat *entry, int flag,
                           struct FTW *where) {
  (void)entry, (void)flag;
  temporaries += strncmp(path + where->base, ".delassus-", 10) == 0;
  return 0;
}

/* Returns 1 for made-by.txt, of which there is no old one: it would have the folder refused. */
static int is_owner(const product *p) {
  return strstr(p->path, "made-by.txt") != NULL;
}

/* Makes a fresh directory with inputs and, for each product, an old file. */
static void fresh_directory(void) {
  if (chdir(scratch)) die("chdir");
  remove_tree("run");
  if (mkdir("run", 0777) || chdir("run")) die("mkdir");
  write_inputs();
  for (int k = 0; k < product_count; k++) {
    const product *p = &products[k];
    char folder[sizeof p->path];
    memcpy(folder, p->path, sizeof folder);
    char *slash = strrchr(folder, '/');
    if (slash) {
      *slash = '\0';
      (void)mkdir(folder, 0777);
    }
    if (!find_input(p->path) && !is_owner(p)) WRITE(p->path, old_text);
  }
}

/* What a run prints on stderr and on stdout, through pipes, which a limit of files spares. */
typedef struct printed {
  int read, write, lines;
  char text[1 << 16];
} printed;
static printed prints[2];

static void open_prints(void) {
  for (int k = 0; k < 2; k++) {
    int ends[2];
    if (pipe2(ends, O_NONBLOCK | O_CLOEXEC)) die("pipe");
    prints[k].read = ends[0];
    prints[k].write = ends[1];
  }
}

/* Takes what was printed and counts its lines, without those on a missing gnuplot. */
static void take_prints(void) {
  for (int k = 0; k < 2; k++) {
    printed *p = &prints[k];
    const ssize_t got = read(p->read, p->text, sizeof p->text - 1);
    p->text[got > 0 ? got : 0] = '\0';
    p->lines = 0;
    for (const char *line = p->text; (line = strchr(line, '\n')); line++)
      p->lines++;
    for (const char *line = p->text; k == 0 && (line = strstr(line, "gnuplot did not")); line++)
      p->lines--;
  }
}

/* ---- runs ------------------------------------------------------------------------------------ */

/* Runs a case with the k-th call of a kind failing; returns the status of waitpid. */
static int run_case(const fault_case *c, kind what, long k) {
  *seen = (shared){.live = 0};
  (void)fflush(NULL);
  const pid_t child = fork();
  if (child == 0) {
    const int out = what == STDOUT ? open("/dev/full", O_WRONLY) : prints[1].write;
    if (out < 0 || dup2(out, 1) < 0 || dup2(prints[0].write, 2) < 0) _exit(99);
    (void)alarm(300);
    if (what == BYTES) {
      const struct rlimit limit = {(rlim_t)k, RLIM_INFINITY};
      (void)signal(SIGXFSZ, SIG_IGN);
      (void)setrlimit(RLIMIT_FSIZE, &limit);
    }
    failing = what;
    failing_at = k;
    counting = 1;
    int status = c->line ? run_line(c->line) : run_callback();
    counting = 0;
    _exit(status);
  }
  int status = -1;
  if (child < 0 || waitpid(child, &status, 0) != child) die("fork");
  take_prints();
  return status;
}

/* Complains of a run; `text` says of what. */
static int blame(const fault_case *c, kind what, long k, const char *text, const char *more) {
  printf("FAILED: %s, %s %ld: %s %s\n", c->name, kind_names[what], k, text, more);
  return 0;
}

/* What a run without failures does. */
typedef struct usual {
  shared calls;
  int status, lines; /* lines of stdout */
} usual;

static int check_run(const fault_case *c, kind what, long k, int status, const usual *clean) {
  size_t size = 0;
  int good = 1;
  if (!WIFEXITED(status)) return blame(c, what, k, "ended by a signal", "");
  const int code = WEXITSTATUS(status), reached = what >= BYTES || seen->calls[what] >= k;
  const char *words = prints[0].text;
  char text[40];
  (void)snprintf(text, sizeof text, "status %d, not told:", code);
  /* without a word all has to be there: a second attempt has served */
  const int done = code == clean->status && what != STDOUT && prints[1].lines == clean->lines;
  if (code != 2 && !(done && (what == MALLOC || what == READ || what == BYTES)))
    good = blame(c, what, k, text, words);
  if (code == 2 && (prints[0].lines != 1 || strncmp(words, "delassus: ", 10) != 0))
    good = blame(c, what, k, "not one line:", words);
  if (!reached) good = blame(c, what, k, "not reached", "");
  if (seen->live > clean->calls.live) good = blame(c, what, k, "leak", "");
  temporaries = 0;
  (void)nftw(".", count_temporary, 8, FTW_PHYS);
  if (temporaries) good = blame(c, what, k, "a temporary file is left", "");
  for (int e = 0; e < product_count; e++) {
    const product *p = &products[e];
    char *now = read_whole(p->path, &size);
    const product *input = find_input(p->path);
    const int is_old = now && (input ? is_same(input, now, size) : strcmp(now, old_text) == 0);
    if (!now && is_owner(p) && code == 2) continue;
    if (!now)
      good = blame(c, what, k, "a file is lost:", p->path);
    else if (!is_old && !is_whole(p, now, size))
      good = blame(c, what, k, "half a file:", p->path);
    else if (code != 2 && !is_whole(p, now, size))
      good = blame(c, what, k, "not written:", p->path);
    free(now);
  }
  return good;
}

/* Attacks one case; returns the number of failures, adds to *runs. */
static long attack(const fault_case *c, long most, long *runs) {
  usual clean;
  product_count = 0;
  fresh_directory();
  for (int k = 0; k < input_count; k++)
    free(inputs[k].text);
  input_count = 0;
  (void)nftw(".", note_input, 8, FTW_PHYS);
  const int ended = run_case(c, KINDS, 0);
  clean = (usual){*seen, WIFEXITED(ended) ? WEXITSTATUS(ended) : -1, prints[1].lines};
  if (clean.status == 2 && strstr(prints[0].text, dls_status_text(DLS_E_UNSUPPORTED))) {
    printf("%-9s skipped: %s", c->name, prints[0].text);
    return 0;
  }
  if (clean.status != 0 && clean.status != 1) {
    printf("FAILED: %s, without a failing call: %s\n", c->name, prints[0].text);
    return 1;
  }
  (void)nftw(".", note_product, 8, FTW_PHYS);
  size_t largest = 0;
  int files = 0;
  for (int k = 0; k < product_count; k++) {
    const product *input = find_input(products[k].path);
    const int written = !input || !is_same(input, products[k].text, products[k].size);
    files += written;
    if (written && products[k].size > largest) largest = products[k].size;
  }
  clean.calls.calls[BYTES] = (long)(largest > 0 ? largest - 1 : 0);
  clean.calls.calls[STDOUT] = clean.lines > 0;
  printf("%-9s", c->name);
  long bad = 0;
  for (kind what = MALLOC; what < KINDS; what++) {
    const long all = clean.calls.calls[what],
               limit = what == BYTES && (!most || most > 40) ? 40 : most;
    const long count = !limit || limit > all ? all : limit;
    for (long e = 0; e < count; e++) {
      const long k = what == BYTES ? e * all / count : 1 + e * all / count;
      fresh_directory();
      const int end = run_case(c, what, k);
      if (!check_run(c, what, k, end, &clean)) bad++;
    }
    *runs += count;
    printf(" %s %ld/%ld", kind_names[what], count, what == BYTES ? count : all);
    (void)fflush(stdout);
  }
  printf("; %d files; %ld failures\n", files, bad);
  for (int k = 0; k < product_count; k++)
    free(products[k].text);
  return bad;
}

int main(int argc, char **argv) {
  long most = 0, bad = 0, runs = 0;
  int k = 1;
  if (k < argc && !strncmp(argv[k], "--most=", 7)) most = atol(argv[k++] + 7);
  seen = mmap(NULL, sizeof *seen, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (seen == MAP_FAILED || !getcwd(home, sizeof home) || !mkdtemp(scratch)) die("no directory");
  open_prints();
  (void)setenv("PATH", scratch, 1); /* no gnuplot */
  setvbuf(stdout, NULL, _IOLBF, 0);
  for (const fault_case *c = cases; c->name; c++) {
    int wanted = k == argc;
    for (int e = k; e < argc; e++)
      wanted |= !strcmp(argv[e], c->name);
    if (wanted) bad += attack(c, most, &runs);
  }
  if (chdir(home)) die("chdir");
  remove_tree(scratch);
  printf("%ld runs with a failing call, %ld broke a promise\n", runs, bad);
  return bad > 0;
}
