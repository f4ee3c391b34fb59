/* test_text.c: problems in text: what is read, and what is refused with its line. */
#define _GNU_SOURCE
#include <unistd.h>

#include "delassus/files.h"
#include "files/file.h"
#include "run.h"

static char path[] = "/tmp/delassus-text-XXXXXX"; /* made in main */

static void write_bytes(const char *bytes, size_t size) {
  FILE *file = fopen(path, "wb");
  ck_assert_ptr_nonnull(file);
  ck_assert_uint_eq(fwrite(bytes, 1, size, file), size);
  ck_assert_int_eq(fclose(file), 0);
}

static dls_status read_text(const char *content, dls_text **text, dls_error *error) {
  write_bytes(content, strlen(content));
  const dls_status status = dls_text_read(text, path, error);
  return status;
}

static const char good[] = "# a comment\n"
                           "title  two words  \r\n"
                           "contact 2 1\n"
                           "\n"
                           "mu 1/2\n"
                           "W\n"
                           "  2   -1e0 \r\n"
                           "\t0.5 3\n"
                           "solution 1 2\n"
                           "none\n"
                           "q -1 +.25";

TEST(a_contact_problem) {
  dls_text *text;
  dls_contact p;
  int n;
  const double *M, *q;
  dls_error error;
  const char *key;
  ck_assert_int_eq(read_text(good, &text, NULL), DLS_OK);
  ck_assert(!dls_text_is_lcp(text));
  ck_assert_str_eq(dls_text_title(text), "two words");
  ck_assert_int_eq(dls_text_contact(text, &p, NULL), DLS_OK);
  ck_assert(p.d == 2 && p.nc == 1 && p.W.ld == 2 && p.mu[0] == 0.5);
  ck_assert(p.W.a[0] == 2 && p.W.a[2] == -1 && p.W.a[1] == 0.5 && p.W.a[3] == 3);
  ck_assert(p.q[0] == -1 && p.q[1] == 0.25);
  ck_assert_int_eq(dls_contact_check(&p, NULL), DLS_OK);
  ck_assert_str_eq(dlsi_text_line(text, 1, &key), "1 2");
  ck_assert_str_eq(key, "solution");
  ck_assert_str_eq(dlsi_text_line(text, 2, NULL), "");
  ck_assert_ptr_null(dlsi_text_line(text, 3, &key));
  ck_assert_ptr_null(dlsi_text_line(text, -1, &key));
  ck_assert_int_eq(dls_text_lcp(text, &n, &M, &q, &error), DLS_E_ARGUMENT);
  ck_assert_str_eq(error.function, "dls_text_lcp");
  dls_text_destroy(text);
}

/* Text from Windows begins by a byte order mark; Fortran writes exponents of double precision. */
TEST(mark_and_exponents_of_fortran) {
  dls_text *text;
  dls_contact p;
  ck_assert_int_eq(read_text("\xef\xbb\xbf"
                             "contact 1 1\nW\n2D0\nq -1.5d-1\nmu 0\n",
                             &text, NULL),
                   DLS_OK);
  ck_assert_int_eq(dls_text_contact(text, &p, NULL), DLS_OK);
  ck_assert(p.W.a[0] == 2 && p.q[0] == -0.15);
  dls_text_destroy(text);
  double *a;
  int rows, cols;
  const char *mtx = "\xef\xbb\xbf%%MatrixMarket matrix array real general\n2 1\n1.25D+2\n-3d-1\n";
  write_bytes(mtx, strlen(mtx));
  ck_assert_int_eq(dls_mtx_read(path, &rows, &cols, &a, NULL), DLS_OK);
  ck_assert(rows == 2 && cols == 1 && a[0] == 125 && a[1] == -0.3);
  dls_mtx_free(a);
  static const char *const wrong[] = {"\xef\xbb",
                                      "\xef",
                                      "\xef\xbbW",
                                      "\xef\xbb\xbf",
                                      "contact 1 1\nW\n2D\nq 1\nmu 0\n",
                                      "contact 1 1\nW\n2DE1\nq 1\nmu 0\n",
                                      "contact 1 1\nW\nD1\nq 1\nmu 0\n"};
  for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++)
    ck_assert_int_eq(read_text(wrong[k], &text, NULL), DLS_E_FORMAT);
}

TEST(an_lcp) {
  dls_text *text;
  dls_contact p;
  int n;
  const double *M, *q;
  ck_assert_int_eq(read_text("lcp 2\nM\n1 2\n3 4\nq -1 0\nW is words here\n", &text, NULL), DLS_OK);
  ck_assert(dls_text_is_lcp(text));
  ck_assert_str_eq(dls_text_title(text), "");
  ck_assert_int_eq(dls_text_lcp(text, &n, &M, &q, NULL), DLS_OK);
  ck_assert(n == 2 && M[1] == 3 && M[2] == 2 && q[0] == -1);
  ck_assert_int_eq(dls_text_lcp(text, NULL, &M, &q, NULL), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_text_lcp(text, &n, NULL, &q, NULL), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_text_lcp(text, &n, &M, NULL, NULL), DLS_E_ARGUMENT);
  REFUSES(ARGUMENT, "text", -1, dls_text_contact, text, &p);
  dls_text_destroy(text);
}

TEST(refused_with_the_line) {
  static const struct {
    const char *content;
    int line;
  } bad[] = {{"", -1},
             {"q 1\n", 1},
             {"contact 2 1\n", -1},
             {"contact 4 1\n", 1},
             {"contact 2 0\n", 1},
             {"contact 2 1.5\n", 1},
             {"contact 2\n", 1},
             {"contact 3 2000000000\n", 1},
             {"lcp 2 2\n", 1},
             {"lcp 1\nlcp 1\n", 2},
             {"lcp 1\nM 1\n", 2},
             {"lcp 2\nM\n1 2\n", 3},
             {"lcp 2\nM\n1 2\n3\n", 4},
             {"lcp 2\nM\n1 2\n3 4 5\n", 4},
             {"lcp 2\nM\n1 2\n3 x\n", 4},
             {"lcp 2\nM\n1 2\n3 inf\n", 4},
             {"lcp 2\nM\n1 2\n3 1/0\n", 4},
             {"lcp 2\nM\n1 2\n3 1e999\n", 4},
             {"lcp 1\nM\n1\nM\n1\n", 4},
             {"lcp 1\nM\n1\nq 1 2\n", 4},
             {"lcp 1\nM\n1\nq\n", 4},
             {"lcp 1\nM\n1\nq nan\n", 4},
             {"lcp 1\nM\n1\n", -1},
             {"lcp 30000\nM\n1\n", 2},
             {"contact 2 1\nW\n1 0\n0 1\nq 1 1\n", -1},
             {"contact 2 1\nW\n1 0\n0 1\nq 1 1\nmu -1\n", -1},
             {"contact 2 1\nM\n1 0\n0 1\nq 1 1\nmu 1\n", -1}};
  for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
    dls_text *text = (dls_text *)&bad;
    dls_error error = {0};
    const dls_status status = read_text(bad[k].content, &text, &error);
    ck_assert_msg(status == DLS_E_FORMAT && error.index == bad[k].line, "%zu: %s", k,
                  error.message);
    ck_assert_ptr_null(text);
    ck_assert_str_eq(error.argument, "path");
    ck_assert_str_eq(error.function, "dls_text_read");
  }
}

/* What is said of a line: its number, its first word, and why; of the whole file no line. */
TEST(words_of_refusals) {
  static const struct {
    const char *content, *words;
    double value;
  } bad[] = {{"lcp 2147483647\nq 1\n", "line 2, 'q': has too few numbers", 0},
             {"lcp 2147483648\n", "line 1, 'lcp': needs n >= 1", 0},
             {"lcp 0\n", "line 1, 'lcp': needs n >= 1", 0},
             {"lcp 1 1\n", "line 1, 'lcp': needs sizes", 0},
             {"contact 3 715827882\nW\n1\n", "line 2, 'W': has too few rows", 0},
             {"contact 3 715827883\n", "line 1, 'contact': needs d = 1, 2 or 3 and nc >= 1", 0},
             {"contact 0 1\n", "needs d = 1, 2 or 3", 0},
             {"contact 2.5 2\n", "needs d = 1, 2 or 3", 0},
             {"# 1\n\n  # 3\ncontact 1 1\nlcp 1\n", "line 5, 'lcp': stands there twice", 0},
             {"M\n1\n", "line 1, 'M': stands before the sizes", 0},
             {"mu 1\n", "line 1, 'mu': stands before the sizes", 0},
             {"contact 2 1\nmu 1\nmu 1\n", "line 3, 'mu': stands there twice", 0},
             {"lcp 2\nM 1 2\n", "line 2, '1 2': belongs under its key", 0},
             {"lcp 2\nM\n1 2\n", "line 3, 'M': has too few rows", 0},
             {"lcp 3\nM\n1 2 3\n4 5 6\n7 8\n", "line 5, '7 8': has too few numbers, too many", 0},
             {"lcp 3\nM\n1 2 3\n4 5 6\n7 8 9\nq 1 2 \n", "line 6, 'q': has too few numbers", 0},
             {"lcp 1\nM\n1\n", "q is missing", 0},
             {"lcp 1\nq 1\n", "M is missing", 0},
             {"contact 1 1\nq 1\nmu 0\n", "W is missing", 0},
             {"contact 1 1\nW\n1\nq 1\n", "mu is missing", 0},
             {"contact 1 3\nW\n1 0 0\n0 1 0\n0 0 1\nq 1 1 1\nmu 0 0 -.25\n",
              "mu of candidate 2 is negative", -.25},
             {"contact 1 2\nW\n1 0\n0 1\nq 1 1\nmu -2 0\n", "mu of candidate 0 is negative", -2}};
  for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
    dls_text *text;
    dls_error e = {0};
    const dls_status status = read_text(bad[k].content, &text, &e);
    ck_assert_msg(status == DLS_E_FORMAT && strstr(e.message, bad[k].words), "%s", e.message);
    const char *line = strstr(e.message, "line ");
    ck_assert(e.value == bad[k].value && e.index == (line ? atoi(line + 5) : -1));
  }
}

/* Words of a file that are no text for a terminal are shown in the message, never sent. */
TEST(controls_are_shown) {
  static const struct {
    const char *content, *message;
  } bad[] = {{"lcp 1\nM\n\033[31m\x07\x7f\n", "'\\x1b[31m\\x07\\x7f': has too few"},
             {"lcp 1\nM\n1\x01 1\n", "'1\\x01 1': has too few"},
             {"lcp 1\nM\n\xc2\x85\xe2\x80\xae\xff\n", "'\\xc2\\x85\\xe2\\x80\\xae\\xff': has"},
             {"lcp 1\nM\n\xc3\xa9\n", "'\xc3\xa9': has too few"}};
  for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
    dls_text *text;
    dls_error e = {0};
    ck_assert_int_eq(read_text(bad[k].content, &text, &e), DLS_E_FORMAT);
    ck_assert_msg(strstr(e.message, bad[k].message) != NULL, "%zu: %s", k, e.message);
  }
}

/* As many numbers as characters allow: no blank and no line end too much. */
TEST(the_shortest_files) {
  static const char *const content[] = {"lcp 1\nq 5\nM\n1", "lcp 2\nq 5 6\nM\n1 2\n3 4",
                                        "lcp 3\nq 5 6 7\nM\n1 2 3\n4 5 6\n7 8 9",
                                        "contact 3 1\nmu 1\nq 5 6 7\nW\n1 2 3\n4 5 6\n7 8 9"};
  for (int k = 0; k < 4; k++) {
    dls_text *text;
    int n = k == 3 ? 3 : k + 1;
    const double *M, *q;
    dls_contact p;
    ck_assert_int_eq(read_text(content[k], &text, NULL), DLS_OK);
    if (k == 3) {
      ck_assert_int_eq(dls_text_contact(text, &p, NULL), DLS_OK);
      ck_assert(p.d == 3 && p.nc == 1 && p.W.rows == 3 && p.W.cols == 3 && p.W.ld == 3);
      M = p.W.a, q = p.q;
    } else
      ck_assert_int_eq(dls_text_lcp(text, &n, &M, &q, NULL), DLS_OK);
    ck_assert_int_eq(n, k == 3 ? 3 : k + 1);
    for (int e = 0; e < n * n; e++)
      ck_assert(M[e] == 1 + e / n + n * (e % n));
    for (int e = 0; e < n; e++)
      ck_assert(q[e] == 5 + e);
    dls_text_destroy(text);
  }
}

/* Files of any length about the sizes of the buffer, 4096 and 3 4096; other lines, up to beyond 3
 * 16, in their order, and the first title. */
TEST(long_files) {
  static char content[14000];
  static const char begin[] = "lcp 1\nq 5\nM\n1\ntitle ", end[] = "\ntitle no";
  for (int about = 4096; about <= 12288; about += 8192)
    for (int size = about - 3; size <= about + 2; size++) {
      dls_text *text;
      const size_t fill = (size_t)size - strlen(begin) - strlen(end);
      char *at = content + sprintf(content, "%s", begin);
      memset(at, 'x', fill);
      strcpy(at + fill, end);
      ck_assert_int_eq(read_text(content, &text, NULL), DLS_OK);
      ck_assert_uint_eq(strlen(dls_text_title(text)), fill);
      ck_assert_str_eq(dlsi_text_line(text, 1, NULL), "no");
      dls_text_destroy(text);
    }
  for (int lines = 0; lines <= 60; lines++) {
    dls_text *text;
    char *at = content + sprintf(content, "lcp 1\nq 5\nM\n1\n");
    for (int k = 0; k < lines; k++)
      at += sprintf(at, "key%d \t text %d \r\n", k, k);
    ck_assert_int_eq(read_text(content, &text, NULL), DLS_OK);
    for (int k = 0; k < lines; k++) {
      char words[20];
      const char *key;
      sprintf(words, "text %d", k);
      ck_assert_str_eq(dlsi_text_line(text, k, &key), words);
      sprintf(words, "key%d", k);
      ck_assert_str_eq(key, words);
    }
    ck_assert_ptr_null(dlsi_text_line(text, lines, NULL));
    dls_text_destroy(text);
  }
}

TEST(no_text) {
  dls_text *text = NULL;
  dls_error error;
  static const char zero[] = "lcp 1\nM\n1\nq 1\0\n";
  write_bytes(zero, sizeof zero);
  ck_assert_int_eq(dls_text_read(&text, path, &error), DLS_E_FORMAT);
  ck_assert_int_eq(dls_text_read(&text, "no/such/file", &error), DLS_E_FILE);
  ck_assert_int_eq(dls_text_read(&text, ".", &error), DLS_E_FILE);
  REFUSES(ARGUMENT, "out", -1, dls_text_read, NULL, path);
  REFUSES(ARGUMENT, "path", -1, dls_text_read, &text, NULL);
  dls_contact p;
  int n;
  const double *M, *q;
  ck_assert_int_eq(dls_text_contact(NULL, &p, NULL), DLS_E_ARGUMENT);
  ck_assert_int_eq(dls_text_lcp(NULL, &n, &M, &q, NULL), DLS_E_ARGUMENT);
  ck_assert(!dls_text_is_lcp(NULL) && !dlsi_text_line(NULL, 0, NULL) && !*dls_text_title(NULL));
  dls_text_destroy(NULL);
}

TEST(numbers_alone) {
  double x[3] = {7, 7, 7};
  ck_assert(dlsi_text_numbers(" 1 -2/4\t3e2 ", 3, x) && x[0] == 1 && x[1] == -0.5 && x[2] == 300);
  ck_assert(dlsi_text_numbers("", 0, NULL));
  ck_assert(!dlsi_text_numbers("1 2", 3, x) && !dlsi_text_numbers("1 2 3 4", 3, x));
  ck_assert(!dlsi_text_numbers("1/", 1, x) && !dlsi_text_numbers("/2", 1, x));
  ck_assert(!dlsi_text_numbers(NULL, 1, x) && !dlsi_text_numbers("1", 1, NULL));
}

TEST(each_malloc_fails) {
  write_bytes(good, strlen(good));
  dls_text *text;
  MALLOCS_FAIL(dls_text_read(&text, path, NULL), !text, DLS_OK, 6);
  dls_text_destroy(text);
}

int main(void) {
  const int made = mkstemp(path);
  if (made < 0 || close(made)) return 1;
  const int failures = run_tests("text", NULL, NULL);
  (void)remove(path);
  return failures;
}
