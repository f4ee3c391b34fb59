/* common.c: clocks, medians, child processes, options, pages of results, as common.h says. */
#include "common.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { child_done = 7 /* exit status that no library uses */ };

dls_status bench_reduce(dls_reduction **out, const dls_model *model, dls_error *error) {
  dls_reduction_settings settings;
  dls_reduction_settings_init(&settings);
  settings.on = DLS_ON_W;
  return dls_reduction_create(out, model, &settings, error);
}

/* Reads the clock of the calling thread first: Linux brings the clock of a process with a CPU limit
 * up to date at a tick (1 ms) or when the clock of a thread is read. */
double bench_seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void bench_start(bench_clock *c) {
  c->since = bench_seconds();
}

double bench_stop(bench_clock *c) {
  c->last = bench_seconds() - c->since;
  c->all += c->last;
  if (c->count++ == 0 || c->last < c->least) c->least = c->last;
  return c->last;
}

int bench_runs(bench_clock *c, int least, int most, double seconds) {
  if (c->since > 0) (void)bench_stop(c);
  const int more = c->count < least || (c->count < most && c->all < seconds);
  c->since = 0;
  if (more) bench_start(c);
  return more;
}

static int ascending(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

double bench_draw(uint64_t *state) {
  *state = *state * 6364136223846793005u + 1442695040888963407u;
  return (double)(*state >> 11) * 0x1p-52 - 1;
}

double bench_median(size_t n, double *x) {
  if (n == 0) return NAN;
  qsort(x, n, sizeof *x, ascending);
  return (x[(n - 1) / 2] + x[n / 2]) / 2;
}

double bench_distance(size_t n, const double *a, const double *b) {
  double difference = 0, size = 0;
  for (size_t k = 0; k < n; k++) {
    difference += (a[k] - b[k]) * (a[k] - b[k]);
    size += b[k] * b[k];
  }
  return sqrt(difference / size);
}

double bench_exponent(size_t n, const double *x, const double *y, size_t last) {
  double count = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (size_t k = n > last ? n - last : 0; k < n; k++) {
    if (!(y[k] > 0 && y[k] < INFINITY)) continue;
    const double u = log(x[k]), v = log(y[k]);
    count++;
    sx += u;
    sy += v;
    sxx += u * u;
    sxy += u * v;
  }
  return (count * sxy - sx * sy) / (count * sxx - sx * sx);
}

void *bench_shared(size_t bytes) {
  void *p = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  return p == MAP_FAILED ? NULL : p;
}

double bench_memory(const char *name) {
  char line[256];
  double bytes = NAN;
  FILE *file = fopen("/proc/self/status", "r");
  while (file && fgets(line, sizeof line, file))
    if (strncmp(line, name, strlen(name)) == 0) bytes = 1024 * atof(line + strlen(name) + 1);
  if (file) fclose(file);
  return bytes;
}

double bench_watch_memory(void) {
  FILE *file = fopen("/proc/self/clear_refs", "w");
  if (file) {
    fputs("5", file);
    fclose(file);
  }
  return bench_memory("VmRSS");
}

int bench_child(void (*work)(void *data), void *data) {
  fflush(NULL);
  const pid_t child = fork();
  if (child == 0) {
    work(data);
    _exit(child_done);
  }
  int status = 0;
  pid_t ended;
  do
    ended = waitpid(child, &status, 0);
  while (ended < 0 && errno == EINTR);
  if (child < 0 || ended != child) return -1;
  if (WIFSIGNALED(status)) return WTERMSIG(status);
  return WIFEXITED(status) && WEXITSTATUS(status) == child_done ? 0 : -1;
}

/* Returns what follows the option in the usage; NULL if the usage does not have it. */
static const char *behind_option(const char *usage, const char *option) {
  const size_t length = strlen(option);
  for (const char *at = usage; (at = strstr(at, option)); at += length)
    if ((at == usage || strchr(" [", at[-1])) && strchr(" ]", at[length])) return at + length;
  return NULL;
}

int bench_options(int argc, char *const *argv, const char *usage) {
  const size_t length = strcspn(usage, " ");
  int good = 1, missing = usage[0] == '-';
  for (int k = 1; k < argc && good; k++) {
    if (strncmp(argv[k], usage, length) == 0 && !argv[k][length]) missing = 0;
    if (argv[k][0] != '-') {
      good = strstr(usage, "...") != NULL;
      continue;
    }
    const char *behind = behind_option(usage, argv[k]);
    good = behind && (!isupper((unsigned char)behind[strspn(behind, " ")]) || ++k < argc);
  }
  if (good && !missing) return 1;
  fprintf(stderr, "usage: %s %s\n", argv[0], usage);
  return 0;
}

const char *bench_word(int argc, char *const *argv, const char *option, const char *otherwise) {
  for (int k = 1; k + 1 < argc; k++)
    if (strcmp(argv[k], option) == 0) return argv[k + 1];
  return otherwise;
}

double bench_number(int argc, char *const *argv, const char *option, double otherwise) {
  const char *word = bench_word(argc, argv, option, NULL);
  return word ? strtod(word, NULL) : otherwise;
}

int bench_list(int argc, char *const *argv, const char *option, int *x, int count, int most) {
  const char *word = bench_word(argc, argv, option, NULL);
  if (word) count = 0;
  for (char *next; word && *word && count < most; word = next + (*next == ','))
    x[count++] = (int)strtol(word, &next, 10);
  return count;
}

int bench_has(int argc, char *const *argv, const char *option) {
  for (int k = 1; k < argc; k++)
    if (strcmp(argv[k], option) == 0) return 1;
  return 0;
}

const char *bench_other(int argc, char *const *argv, const char *usage, int k) {
  for (int i = 1; i < argc; i++) {
    const char *behind = argv[i][0] == '-' ? behind_option(usage, argv[i]) : NULL;
    if (argv[i][0] != '-' && k-- == 0) return argv[i];
    i += behind && isupper((unsigned char)behind[strspn(behind, " ")]);
  }
  return NULL;
}

FILE *bench_open(const char *directory, const char *name) {
  char path[1024];
  snprintf(path, sizeof path, "%s/%s", directory, name);
  FILE *file = fopen(path, "w");
  if (!file) perror(path);
  return file;
}

/* Prints the name of the processor, "a machine" where /proc/cpuinfo does not tell it. */
static void print_processor(FILE *page) {
  char line[256] = "";
  FILE *info = fopen("/proc/cpuinfo", "r");
  const char *name = NULL;
  while (info && !name && fgets(line, sizeof line, info))
    if (strncmp(line, "model name", 10) == 0) name = strchr(line, ':');
  if (info) fclose(info);
  if (name)
    fprintf(page, "%.*s", (int)strcspn(name + 2, "\n"), name + 2);
  else
    fputs("a machine", page);
}

/* Prints the date, and the commit of the source if git is there. */
static void print_date(FILE *page) {
  char text[64];
  const time_t now = time(NULL);
  struct tm day;
  if (gmtime_r(&now, &day) && strftime(text, sizeof text, "%d %B %Y", &day))
    fprintf(page, "%s, ", text);
  FILE *git = popen("git describe --always --dirty=' and changes' 2>/dev/null", "r");
  if (git && fgets(text, sizeof text, git))
    fprintf(page, "commit %.*s, ", (int)strcspn(text, "\n"), text);
  if (git) pclose(git);
}

/* Appends an argument to the command of a page: FCLIB files, and folders of this machine, by a
 * word. */
static void append_argument(char *options, size_t size, const char *argument) {
  const size_t used = strlen(options), length = strlen(argument);
  const int file = length > 5 && strcmp(argument + length - 5, ".hdf5") == 0;
  if (file && used >= 5 && strcmp(options + used - 5, "FILES") == 0) return;
  const char *text = file ? "FILES" : *argument == '/' ? "DIR" : argument;
  snprintf(options + used, size - used, "%s%s", used ? " " : "", text);
}

FILE *bench_page(const char *directory, const char *name, const char *title, int argc,
                 char *const *argv) {
  char file[64], options[1024] = "";
  snprintf(file, sizeof file, "%s.md", name);
  FILE *page = bench_open(directory, file);
  if (!page) return NULL;
  for (int k = 1; k < argc; k++)
    if (strcmp(argv[k], "--out") == 0)
      k++;
    else
      append_argument(options, sizeof options, argv[k]);
  const char *slash = strrchr(argv[0], '/'), *command = getenv("WRITTEN_BY");
  fprintf(page, "# %s\n\nWritten by `", title);
  if (command)
    fputs(command, page);
  else
    fprintf(page, "make bench-%s", slash ? slash + 1 : argv[0]);
  if (!command && *options) fprintf(page, " BENCH='%s'", options);
  fputs("`: ", page);
  print_date(page);
  print_processor(page);
  fputs(", one BLAS thread, compiler " __VERSION__ ".\n\n", page);
  return page;
}

FILE *bench_program(int argc, char *const *argv, const char *usage, const char *name,
                    const char *title) {
  if (!bench_options(argc, argv, usage)) exit(2);
  FILE *page = bench_page(bench_word(argc, argv, "--out", "build"), name, title, argc, argv);
  if (!page) exit(1);
  return page;
}

void bench_print(FILE *page, const char *format, ...) {
  va_list arguments;
  FILE *const to[] = {page, stdout};
  for (int k = 0; k < 2; k++) {
    if (!to[k]) continue;
    va_start(arguments, format);
    vfprintf(to[k], format, arguments);
    va_end(arguments);
  }
  fflush(stdout);
  if (page) fflush(page);
}
