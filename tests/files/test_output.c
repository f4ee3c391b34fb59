/* test_output.c: every written file is the old one or a whole new one, by any kind of name. */
#define _GNU_SOURCE
#include <dirent.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "delassus.h"
#include "delassus/fe.h"
#include "program.h"
#include "run.h"

static char path[128];
static const double two[] = {1, 2}, many[40000] = {1};

static const char *in_directory(const char *name) {
  static char room[128];
  (void)snprintf(room, sizeof room, "%s/%s", directory, name);
  return room;
}

static void setup(void) {
  make_directory();
  (void)strcpy(path, in_directory("a.mtx"));
  ck_assert_int_eq(dls_mtx_write(path, &(dls_dense){2, 1, 2, two}, NULL), DLS_OK);
}

static void teardown(void) {
  remove_directory();
}

/* Returns the rows of a matrix file, -1 if it is no whole one. */
static int rows_of(const char *name) {
  int rows = -1, cols;
  double *a;
  if (dls_mtx_read(name, &rows, &cols, &a, NULL)) rows = -1;
  dls_mtx_free(a);
  return rows;
}

/* Expects `count` entries in the directory: no temporary file is left. */
static void expect_entries(int count) {
  DIR *open = opendir(directory);
  ck_assert_ptr_nonnull(open);
  while (readdir(open))
    count--;
  ck_assert_int_eq(closedir(open), 0);
  ck_assert_int_eq(count, -2); /* . and .. */
}

/* Limits files to `most` bytes, as a full disk does. */
static void limit_files(rlim_t most) {
  struct rlimit limit;
  (void)signal(SIGXFSZ, SIG_IGN);
  ck_assert_int_eq(getrlimit(RLIMIT_FSIZE, &limit), 0);
  limit.rlim_cur = most;
  ck_assert_int_eq(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

static dls_status write_rows(const char *name, int rows, dls_error *error) {
  return dls_mtx_write(name, &(dls_dense){rows, 1, rows, many}, error);
}

TEST(full_disk_keeps_the_old_file) {
  dls_error error;
  for (int rows = 100; rows <= 40000; rows *= 20) { /* fails at the end, and on the way */
    limit_files(1000);
    const dls_status status = write_rows(path, rows, &error);
    limit_files(RLIM_INFINITY);
    expect_error(status, &error, DLS_E_FILE, "dls_mtx_write", "path", -1);
    ck_assert_int_eq(rows_of(path), 2);
    expect_entries(1);
  }
}

TEST(full_disk_keeps_the_old_problem) {
  dls_error error;
  const double W[] = {1, 0, 0, 1}, q[] = {-1, 0}, mu[] = {.5};
  const dls_contact problem = {.d = 2, .nc = 1, .W = {2, 2, 2, W}, .q = q, .mu = mu};
  const char *name = in_directory("b.hdf5");
  dls_fclib *file;
  if (dls_fclib_write_local(name, &problem, "old", NULL, NULL, NULL) == DLS_E_UNSUPPORTED) return;
  limit_files(1000);
  const dls_status status = dls_fclib_write_local(name, &problem, "new", NULL, NULL, &error);
  limit_files(RLIM_INFINITY);
  expect_error(status, &error, DLS_E_FILE, "dls_fclib_write_local", "path", -1);
  ck_assert_int_eq(dls_fclib_read(&file, name, NULL), DLS_OK);
  ck_assert_str_eq(dls_fclib_title(file), "old");
  dls_fclib_destroy(file);
  expect_entries(2);
}

/* Asks for more rows than fit: those of before stay, and the next row finds its place. */
TEST(full_disk_keeps_the_collection) {
  dls_error error;
  dls_fe_series *series;
  char line[200], long_name[600];
  memset(long_name, 'a', sizeof long_name);
  long_name[sizeof long_name - 1] = '\0';
  ck_assert_int_eq(dls_fe_series_create(&series, in_directory("s.pvd"), NULL), DLS_OK);
  ck_assert_int_eq(dls_fe_series_add(series, 1, 0, "one", NULL), DLS_OK);
  limit_files(500);
  const dls_status status = dls_fe_series_add(series, 2, 0, long_name, &error);
  limit_files(RLIM_INFINITY);
  expect_error(status, &error, DLS_E_FILE, "dls_fe_series_add", "path", -1);
  ck_assert_int_eq(dls_fe_series_add(series, 3, 0, "three", NULL), DLS_OK);
  ck_assert_int_eq(dls_fe_series_finish(series, NULL), DLS_OK);
  FILE *file = fopen(in_directory("s.pvd"), "r");
  int lines = 0, sets = 0;
  while (fgets(line, sizeof line, file)) {
    lines++;
    sets += strstr(line, "one") || strstr(line, "three");
  }
  (void)fclose(file);
  ck_assert_int_eq(sets, 2);
  ck_assert_int_eq(lines, 7);
  expect_entries(2);
}

/* Writes by a link to a link, from another directory. */
TEST(a_link_stays) {
  struct stat entry;
  char link[128], target[32];
  ck_assert_int_eq(mkdir(in_directory("sub"), 0777), 0);
  ck_assert_int_eq(symlink("../a.mtx", in_directory("sub/one")), 0);
  ck_assert_int_eq(symlink("sub/one", in_directory("two")), 0);
  (void)strcpy(link, in_directory("two"));
  ck_assert_int_eq(write_rows(link, 3, NULL), DLS_OK);
  ck_assert_int_eq(rows_of(path), 3);
  ck_assert_int_eq(lstat(link, &entry), 0);
  ck_assert(S_ISLNK(entry.st_mode));
  ck_assert_int_eq(readlink(in_directory("sub/one"), target, sizeof target), 8);
  expect_entries(3);
}

TEST(a_link_to_nothing_makes_the_file) {
  ck_assert_int_eq(symlink("new.mtx", in_directory("link")), 0);
  ck_assert_int_eq(write_rows(in_directory("link"), 3, NULL), DLS_OK);
  ck_assert_int_eq(rows_of(in_directory("new.mtx")), 3);
  expect_entries(3);
}

TEST(links_without_an_end) {
  dls_error error;
  ck_assert_int_eq(symlink("b", in_directory("a")), 0);
  ck_assert_int_eq(symlink("a", in_directory("b")), 0);
  expect_error(write_rows(in_directory("a"), 3, &error), &error, DLS_E_FILE, "dls_mtx_write",
               "path", -1);
  expect_entries(3);
}

/* What the link says fits into a path, but not behind the directory. */
TEST(a_link_too_long_to_follow) {
  dls_error error;
  struct stat entry;
  char target[4096] = "";
  for (int k = 0; k < 4088; k += 2)
    (void)memcpy(target + k, "./", 3);
  (void)strcpy(target + 4088, "a.mtx");
  ck_assert_int_eq(symlink(target, in_directory("far")), 0);
  expect_error(write_rows(in_directory("far"), 3, &error), &error, DLS_E_FILE, "dls_mtx_write",
               "path", -1);
  ck_assert_int_eq(lstat(in_directory("far"), &entry), 0);
  ck_assert(S_ISLNK(entry.st_mode));
  ck_assert_int_eq(rows_of(path), 2);
  expect_entries(2);
}

TEST(the_mode_stays) {
  struct stat entry;
  ck_assert_int_eq(chmod(path, 0640), 0);
  const mode_t mask = umask(0077);
  ck_assert_int_eq(write_rows(path, 3, NULL), DLS_OK);
  ck_assert_int_eq(stat(path, &entry), 0);
  ck_assert_int_eq(entry.st_mode & 0777, 0640);
  ck_assert_int_eq(write_rows(in_directory("new"), 3, NULL), DLS_OK);
  ck_assert_int_eq(stat(in_directory("new"), &entry), 0);
  ck_assert_int_eq(entry.st_mode & 0777, 0600);
  (void)umask(mask);
}

/* Refuses a file that its owner has made read-only, though its directory can be written to. */
TEST(a_read_only_file_stays) {
  dls_error error;
  if (geteuid() == 0) return; /* may write everything */
  ck_assert_int_eq(chmod(path, 0444), 0);
  expect_error(write_rows(path, 3, &error), &error, DLS_E_FILE, "dls_mtx_write", "path", -1);
  ck_assert_int_eq(rows_of(path), 2);
}

TEST(devices_and_directories) {
  dls_error error;
  struct stat entry;
  ck_assert_int_eq(write_rows("/dev/null", 3, NULL), DLS_OK);
  expect_error(write_rows("/dev/full", 3, &error), &error, DLS_E_FILE, "dls_mtx_write", "path", -1);
  ck_assert_int_eq(stat("/dev/full", &entry), 0);
  ck_assert(S_ISCHR(entry.st_mode));
  expect_error(write_rows(directory, 3, &error), &error, DLS_E_FILE, "dls_mtx_write", "path", -1);
  expect_error(write_rows("", 3, &error), &error, DLS_E_FILE, "dls_mtx_write", "path", -1);
  char *name = malloc(5001);
  memset(name, 'a', 5000);
  name[5000] = '\0';
  expect_error(write_rows(name, 3, &error), &error, DLS_E_FILE, "dls_mtx_write", "path", -1);
  free(name);
  expect_entries(1);
}

/* Writes into the standard output that is a file in the place where it is: what another program
 * has put there before stays. */
TEST(a_file_held_open_is_not_replaced) {
  struct stat before, after;
  FILE *held = fopen(path, "r+");
  char name[64];
  ck_assert_ptr_nonnull(held);
  ck_assert_int_eq(fstat(fileno(held), &before), 0);
  (void)snprintf(name, sizeof name, "/dev/fd/%d", fileno(held));
  ck_assert_int_eq(write_rows(name, 3, NULL), DLS_OK);
  ck_assert_int_eq(stat(path, &after), 0);
  ck_assert(before.st_ino == after.st_ino);
  ck_assert_int_eq(rows_of(path), 3);
  (void)fclose(held);
}

int main(void) {
  return run_tests("output", setup, teardown);
}
