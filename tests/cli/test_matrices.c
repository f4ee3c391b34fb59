/* test_matrices.c: `delassus solve` from the matrices of a host code, and the same host in C. */
#define _GNU_SOURCE

#include "delassus.h"
#include "program.h"
#include "reduced.h"
#include "run.h"

/* Nodes of a cube joined by springs on a rough floor, its top held by soft springs, pushed. */
enum { side = 4, nc = side * side, n = 3 * nc * side, m = 3 * nc };

static int p[n + 1], row[4 * n], each[2 * nc + 1], normal[nc], tangent[2 * nc];
static double value[4 * n], f[n], g[m], mu[nc], ones[2 * nc + 1];
static dls_model model;

static void make_host(void) {
  const int step[] = {1, side, side * side};
  for (int j = 0, e = 0; j < n; j++) {
    const int node = j / 3, at[] = {node % side, node / side % side, node / side / side};
    const int diagonal = e++;
    row[diagonal] = j;
    value[diagonal] = at[2] == side - 1 ? 0.05 : 0;
    for (int k = 0; k < 3; k++) {
      const double stiffness = 1 + 0.3 * k;
      value[diagonal] += stiffness * ((at[k] > 0) + (at[k] < side - 1));
      if (at[k] == side - 1) continue;
      row[e] = j + 3 * step[k];
      value[e++] = -stiffness;
    }
    p[j + 1] = e;
    f[j] = j % 3 == 2 ? -1 : 0.1 * (at[2] + 1) / (j % 3 + 1.0);
  }
  for (int c = 0; c < nc; c++) {
    normal[c] = 3 * c + 2;
    tangent[2 * c] = 3 * c;
    tangent[2 * c + 1] = 3 * c + 1;
    mu[c] = 0.1 + 0.02 * c;
    g[3 * c] = 0.3 * (c % 3);
  }
  for (int k = 0; k <= 2 * nc; k++) {
    each[k] = k;
    ones[k] = 1;
  }
  model = (dls_model){.d = 3, .n = n, .nodes = nc, .factorization = DLS_CHOLESKY};
  model.operator_kind = DLS_STIFFNESS_SPARSE;
  model.Ks = (dls_sparse){n, n, p, row, value};
  model.HN = (dls_sparse){n, nc, each, normal, ones};
  model.HT = (dls_sparse){n, 2 * nc, each, tangent, ones};
}

static void run_ok(dls_status status) {
  ck_assert_int_eq(status, DLS_OK);
}

static void put_sparse(const char *name, const char *kind, const dls_sparse *A) {
  FILE *file = open_file(name, "w");
  fprintf(file, "%%%%MatrixMarket matrix coordinate real %s\n%d %d %d\n", kind, A->rows, A->cols,
          A->p[A->cols]);
  for (int j = 0; j < A->cols; j++)
    for (int k = A->p[j]; k < A->p[j + 1]; k++)
      fprintf(file, "%d %d %.17g\n", A->i[k] + 1, j + 1, A->x[k]);
  ck_assert_int_eq(fclose(file), 0);
}

static void put_vector(const char *name, int count, int cols, const double *x) {
  FILE *file = open_file(name, "w");
  fputs("# a comment\n", file);
  for (int k = 0; k < count; k++)
    fprintf(file, "%.17g%c", x[k], (k + 1) % cols ? ',' : '\n');
  ck_assert_int_eq(fclose(file), 0);
}

static void write_host(void) {
  put_sparse("K.mtx", "symmetric", &model.Ks);
  put_sparse("N.mtx", "general", &model.HN);
  put_sparse("T.mtx", "general", &model.HT);
  put_vector("f.txt", n, 3, f);
  put_vector("g.txt", m, 3, g);
  put_vector("mu.txt", nc, 1, mu);
}

static double r[m], u[m], x[n];
static dls_contact problem;
static dls_reduction *reduction;

/* Solves as a host in C does; the caller destroys the reduction. */
static void solve_in_c(void) {
  dls_info info;
  run_ok(reduce_on_W(&reduction, &model, NULL, NULL));
  run_ok(dls_reduction_load(reduction, f, g, NULL));
  run_ok(dls_reduction_contact(reduction, mu, &problem, NULL));
  run_ok(dls_reduction_solve(reduction, mu, NULL, r, u, x, &info, NULL));
}

/* The files r.csv and x.csv of @/out hold the answer of the host in C, digit for digit. */
static void same_as_in_c(int named) { /* named: 1 if contact c is the host's node c + 1 */
  static char want[100000];
  static const char *const words[] = {"free", "slip", "stick"};
  dls_contact_state state[nc];
  run_ok(dls_contact_states(&problem, r, u, state, NULL));
  int at =
      sprintf(want, "candidate_from_0%s,state,gap,r_n,r_t,r_s,u_n,u_t,u_s\n", named ? ",node" : "");
  for (int c = 0; c < nc; c++) {
    const double gap = state[c] == DLS_FREE ? u[3 * c] : 0;
    const double *a = r + 3 * c, *b = u + 3 * c;
    at += named ? sprintf(want + at, "%d,%d", c, c + 1) : sprintf(want + at, "%d", c);
    at += sprintf(want + at, ",%s,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", words[state[c]],
                  gap, a[0], a[1], a[2], b[0], b[1], b[2]);
  }
  ck_assert_str_eq(contents("out/r.csv"), want);
  at = sprintf(want, "unknown_from_0,x\n");
  for (int k = 0; k < n; k++)
    at += sprintf(want + at, "%d,%.17g\n", k, x[k]);
  ck_assert_str_eq(contents("out/x.csv"), want);
}

static int ends_in(const char *text) {
  const size_t length = strlen(output), tail = strlen(text);
  return length >= tail && strcmp(output + length - tail, text) == 0;
}

TEST(equal_to_a_host_in_c) {
  make_host();
  write_host();
  solve_in_c();
  ck_assert_msg(run("solve --stiffness @/K.mtx --HN @/N.mtx --HT @/T.mtx --f @/f.txt --g @/g.txt "
                    "--mu @/mu.txt --csv @/out --print") == 0,
                "%s", output);
  ck_assert(ends_in("\nsolved\n"));
  ck_assert(strstr(output, "candidate state") != NULL);
  same_as_in_c(0);
  /* the condensed problem, written to the last digit, has the answer of W alone */
  dls_contact alone = problem;
  alone.weights = NULL;
  run_ok(dls_solve(&alone, NULL, r, u, NULL, NULL));
  ck_assert_int_eq(dls_mtx_write(path_of("W.mtx"), &problem.W, NULL), DLS_OK);
  put_vector("q.txt", m, 1, problem.q);
  ck_assert_int_eq(run("solve --W @/W.mtx --q @/q.txt --mu @/mu.txt --csv @/out -o @/r.mtx"), 0);
  same_as_in_c(0);
  dls_reduction_destroy(reduction);
  int rows, cols;
  double *again;
  run_ok(dls_mtx_read(path_of("r.mtx"), &rows, &cols, &again, NULL));
  ck_assert_int_eq(rows, m);
  ck_assert_int_eq(memcmp(again, r, sizeof r), 0);
  dls_mtx_free(again);
}

TEST(one_h_one_list_and_npy) {
  make_host();
  write_host();
  solve_in_c();
  /* H has the columns (n, t, s) of each node; --dim is told by mu */
  FILE *file = open_file("H.mtx", "w");
  fprintf(file, "%%%%MatrixMarket matrix coordinate real general\n%d %d %d\n", n, m, m);
  for (int c = 0; c < nc; c++)
    fprintf(file, "%d %d 1\n%d %d 1\n%d %d 1\n", normal[c] + 1, 3 * c + 1, tangent[2 * c] + 1,
            3 * c + 2, tangent[2 * c + 1] + 1, 3 * c + 3);
  ck_assert_int_eq(fclose(file), 0);
  ck_assert_int_eq(run("solve --stiffness @/K.mtx --H @/H.mtx --f @/f.txt --g @/g.txt "
                       "--mu @/mu.txt --csv @/out"),
                   0);
  same_as_in_c(0);
  /* rows (node, normal): t = x, s = n x t = y */
  file = open_file("nodes.txt", "w");
  for (int c = 0; c < nc; c++)
    fprintf(file, "%d 0 0 2\n", c + 1);
  ck_assert_int_eq(fclose(file), 0);
  ck_assert_int_eq(run("solve --stiffness @/K.mtx --nodes @/nodes.txt --f @/f.txt --g @/g.txt "
                       "--mu @/mu.txt --csv @/out"),
                   0);
  same_as_in_c(1);
  /* f as NumPy writes it */
  char header[128];
  const int length = snprintf(header, sizeof header,
                              "{'descr': '<f8', 'fortran_order': False, 'shape': (%d,), }", n);
  file = open_file("f.npy", "w");
  fwrite("\x93NUMPY\1\0", 1, 8, file);
  fputc(length + 1, file);
  fputc(0, file);
  fprintf(file, "%s\n", header);
  fwrite(f, sizeof *f, n, file);
  ck_assert_int_eq(fclose(file), 0);
  ck_assert_msg(run("solve --stiffness @/K.mtx --HN @/N.mtx --HT @/T.mtx --f @/f.npy --g @/g.txt "
                    "--mu @/mu.txt --csv @/out") == 0,
                "%s", output);
  same_as_in_c(0);
  dls_reduction_destroy(reduction);
}

/* A header that is none: beyond the range of an int, which 32 bits would cut to 2 x 2; a version
 * that there is not; a shape cut short. */
TEST(npy_headers) {
  static const struct {
    int version;
    const char *shape;
    int status;
  } headers[] = {{1, "(2, 2)", 0},           {3, "(2, 2)", 0},
                 {9, "(2, 2)", 2},           {0, "(2, 2)", 2},
                 {1, "(4294967298, 2)", 2},  {1, "(2, 4294967298)", 2},
                 {1, "(65536, 65536)", 2},   {1, "(2, 2", 2},
                 {1, "(2, -2)", 2},          {1, "(2, 2, 1)", 2},
                 {1, "(-4294967294, 2)", 2}, {1, "()", 2}};
  write_file("q.txt", "-1\n.5\n");
  for (size_t k = 0; k < sizeof headers / sizeof *headers; k++) {
    static const double W[4] = {2, 0, 0, 2};
    char header[128];
    const int length = snprintf(header, sizeof header,
                                "{'descr': '<f8', 'fortran_order': False, "
                                "'shape': %s, }\n",
                                headers[k].shape);
    FILE *file = open_file("W.npy", "w");
    fprintf(file, "\x93NUMPY%c%c%c%c", headers[k].version, 0, length, 0);
    if (headers[k].version > 1) fwrite("\0", 1, 2, file);
    fputs(header, file);
    fwrite(W, sizeof *W, 4, file);
    ck_assert_int_eq(fclose(file), 0);
    ck_assert_msg(run("solve --W @/W.npy --q @/q.txt --mu .3 --dim 2") == headers[k].status,
                  "%d %s: %s", headers[k].version, headers[k].shape, output);
  }
}

/* The point of examples/point.c, with the numbers of CalculiX: node 7 is held in z. */
/* What can be read once only is read once: pipes, standard input. No copy stays. */
TEST(pipes) {
  static const char program[] = "-V >/dev/null; cat @/%s | ${DELASSUS_PROGRAM:-build/delassus} %s";
  static const struct {
    const char *file, *arguments;
  } lines[] = {{"p.txt", "solve -q -"},
               {"p.txt", "solve -q /dev/stdin"},
               {"p.txt", "info -"},
               {"p.txt", "chart -q --budget=0.1 --out @/c -"},
               {"p.txt", "map -q --out @/m -"},
               {"p.txt", "profile -q --out @/o - @/p.txt"},
               {"q.csv", "solve -q --dim=2 --W=@/W.csv --q=- --mu=0.5"},
               {"W.csv", "solve -q --dim=2 --W=- --q=@/q.csv --mu=0.5"},
               {"l.txt", "solve -q -"},
               {"M.mtx", "solve -q --lcp - @/M.mtx"},
               {"p.hdf5", "solve -q -"}};
  char command[300];
  write_file("p.txt", "contact 2 1\nW\n2 1/2\n1/2 1\nq -1 1/3\nmu 1/2\n");
  write_file("W.csv", "2,0.5\n0.5,1\n");
  write_file("q.csv", "-1\n0.3\n");
  write_file("l.txt", "lcp 1\nM\n2\nq -1\n");
  write_file("M.mtx", "%%MatrixMarket matrix array real general\n1 1\n2\n");
  if (WITH_HDF5) ck_assert_int_eq(run("solve -q @/p.txt -o @/p.hdf5"), 0);
  ck_assert_int_eq(setenv("TMPDIR", path_of(""), 1), 0);
  for (size_t k = 0; k < sizeof lines / sizeof lines[0]; k++) {
    if (!WITH_HDF5 && strstr(lines[k].file, ".hdf5")) continue;
    (void)snprintf(command, sizeof command, program, lines[k].file, lines[k].arguments);
    ck_assert_msg(run(command) == 0, "%s: %s", command, output);
  }
  ck_assert_int_eq(run("-V; ls @/delassus-* @/.delassus-*"), 2); /* of ls: there is none */
  ck_assert_int_eq(run("-V >/dev/null; : | ${DELASSUS_PROGRAM:-build/delassus} solve -"), 2);
  ck_assert_int_eq(run("solve - </dev/null"), 2);
  ck_assert_int_eq(run("solve -q - <@/p.txt"), 0);
}

/* Tables as Windows and Fortran write them. */
TEST(mark_and_exponents) {
  write_file("W.csv", "\xef\xbb\xbf"
                      "2D0;.5d+0\r\n5D-1;1.0\r\n");
  write_file("q.csv", "\xef\xbb\xbf"
                      "-1\r\n3.D-1\r\n");
  write_file("M.mtx", "\xef\xbb\xbf"
                      "%%MatrixMarket matrix coordinate real general\n2 2 4\n"
                      "1 1 2D0\n1 2 .5d0\n2 1 5D-1\n2 2 1\n");
  ck_assert_int_eq(run("solve --dim 2 --W @/W.csv --q @/q.csv --mu .5 --csv @/a"), 0);
  ck_assert_int_eq(run("solve --dim 2 --W @/M.mtx --q @/q.csv --mu .5 --csv @/b"), 0);
  ck_assert_int_eq(run("-V; cmp @/a/r.csv @/b/r.csv"), 0);
  write_file("q.csv", "-1\n3D\n");
  ck_assert_int_eq(run("solve --dim 2 --W @/W.csv --q @/q.csv --mu .5"), 2);
}

/* Normals alone: as many frictions, all 0, as rows of W, or --dim=1. By hand: r = (0, 2),
 * u = (1, 0). */
TEST(normals_alone) {
  static const char answer[] = "candidate_from_0,state,gap,r_n,u_n\n0,free,1,0,1\n1,touch,0,2,0\n";
  write_file("W.txt", "2 1\n1 2\n");
  write_file("q.txt", "-1\n-4\n");
  write_file("mu.txt", "0\n0\n");
  ck_assert_int_eq(run("solve --W @/W.txt --q @/q.txt --mu @/mu.txt --csv @/out"), 0);
  ck_assert_str_eq(contents("out/r.csv"), answer);
  ck_assert_int_eq(run("solve --dim=1 --W @/W.txt --q @/q.txt --csv @/out"), 0);
  ck_assert_str_eq(contents("out/r.csv"), answer);
  ck_assert_int_eq(run("solve --dim=1 --W @/W.txt --q @/q.txt --mu .3"), 2);
  ck_assert(strstr(output, "must be 0 where d = 1"));
}

TEST(calculix) {
  write_file("job.sti", "1 1 3.0000000000000e+00\n1 2 1.0e0\n2 2 2.0e0\n");
  write_file("job.dof", "7.1\n7.2\n");
  write_file("nodes.txt", "7  0 1 0\n");
  write_file("loads.txt", "7 1 5\n7 2 -10\n7 3 100\n");
  ck_assert_msg(run("solve --stiffness @/job.sti --nodes @/nodes.txt --f @/loads.txt --mu 0.2 "
                    "--csv @/out") == 0,
                "%s", output);
  double number[6];
  ck_assert_int_eq(sscanf(strchr(contents("out/r.csv"), '\n'), "\n0,7,slip,%lf,%lf,%lf,%lf", number,
                          number + 1, number + 2, number + 3),
                   4);
  ck_assert_double_eq_tol(number[1], 10.9375, 1e-12);
  ck_assert(strncmp(contents("out/x.csv"), "node,direction,x\n7,1,0.93", 24) == 0);
  write_file("one.txt", "5\n");
  ck_assert_int_eq(run("solve --stiffness @/job.sti --nodes @/nodes.txt --f @/one.txt --mu 1"), 2);
  ck_assert(strstr(output, "holds 1 number, must hold 2, or rows of node, direction") != NULL);
  write_file("job.dof", "7.1\n");
  ck_assert_int_eq(run("solve --stiffness @/job.sti --nodes @/nodes.txt --f @/loads.txt --mu 1"),
                   2);
  ck_assert(strstr(output, "holds 1 unknown, ") != NULL);
  write_file("job.sti", "2 1 3.0\n");
  ck_assert_int_eq(run("solve --stiffness @/job.sti --nodes @/nodes.txt --mu 1"), 2);
  ck_assert(strstr(output, "on or above the diagonal") != NULL);
}

/* A bar of two free nodes, pressed onto a wall on each side. */
TEST(free_body) {
  write_file("K.txt", "1 -1\n-1 1\n");
  write_file("N.txt", "1 0\n0 -1\n");
  write_file("f.txt", "3 1\n");
  ck_assert_int_eq(run("solve --stiffness @/K.txt --HN @/N.txt --f @/f.txt --csv @/out"), 0);
  ck_assert(strstr(output, "on K, of 2 unknowns") != NULL);
  double pressed[2]; /* statics: nothing on the left one, 3 + 1 on the other */
  ck_assert(sscanf(contents("out/r.csv"),
                   "candidate_from_0,state,gap,r_n,u_n 0,free,%*f,%lf,%*f 1,touch,%*f,%lf",
                   &pressed[0], &pressed[1]) == 2);
  ck_assert(pressed[0] == 0 && fabs(pressed[1] - 4) <= 1e-7);
  ck_assert_int_eq(run("solve --stiffness @/K.txt --HN @/N.txt --f @/f.txt --on=K"), 0);
  ck_assert_int_eq(run("solve --stiffness @/K.txt --HN @/N.txt --f @/f.txt --on=W"), 2);
  ck_assert(strstr(output, "singular") && strstr(output, "without --on=W"));
  ck_assert_int_eq(run("solve --stiffness @/K.txt --HN @/N.txt --f @/f.txt -m nlgs"), 2);
  ck_assert_int_eq(run("solve --stiffness @/K.txt --HN @/N.txt --f @/f.txt --on=K -m nlgs"), 2);
  ck_assert(strstr(output, "method") != NULL);
  ck_assert_int_eq(run("solve --stiffness @/K.txt --HN @/N.txt --f @/f.txt --on=V"), 2);
  ck_assert(strstr(output, "is not W or K") != NULL);
}

/* Each line: the arguments, and what the complaint says. */
/* The point of a spring model by lines row column value, H_N without its last rows; by labels. */
TEST(triplets_and_labels) {
  write_file("K.txt", "1 1 3\n1 2 1\n2 1 1\n2 2 2\n3 3 5\n");
  write_file("N.txt", "2 1 1\n");
  write_file("T.txt", "1 1 1\n");
  write_file("f.txt", "5\n-10\n0\n");
  write_file("K.mtx", "1,1, 1,1, 3.\n1,2, 1,1, 1.\n1,2, 1,2, 2.\n9,1, 9,1, 5.\n");
  write_file("nodes.txt", "1 0 1\n");
  ck_assert_int_eq(run("solve --stiffness @/K.txt --HN @/N.txt --HT @/T.txt --f @/f.txt --mu 0.2 "
                       "--triplets --csv @"),
                   0);
  ck_assert_ptr_nonnull(strstr(contents("r.csv"), "\n0,slip,0,10.9375"));
  ck_assert_int_eq(run("solve --stiffness @/K.mtx --nodes @/nodes.txt --f @/f.txt --mu 0.2 "
                       "--csv @"),
                   0);
  ck_assert_ptr_nonnull(strstr(contents("r.csv"), "candidate_from_0,node,state"));
  ck_assert_ptr_nonnull(strstr(contents("r.csv"), "\n0,1,slip,0,10.9375"));
  ck_assert_ptr_nonnull(strstr(contents("x.csv"), "\n9,1,0\n"));
  ck_assert_int_eq(run("solve --stiffness @/K.txt --HN @/N.txt --mu 0"), 2);
  ck_assert_ptr_nonnull(strstr(output, "looks like triplets"));
}

/* Three nodes on springs, 2D, the middle one pressed: sums, moments, fields, a picture; by HN and
 * coordinates and by a list of nodes with them. */
TEST(coordinates) {
  write_file("K.txt", "2 0 -1 0 0 0\n0 2 0 -1 0 0\n-1 0 2 0 -1 0\n0 -1 0 2 0 -1\n0 0 -1 0 2 0\n"
                      "0 0 0 -1 0 2\n");
  write_file("N.txt", "0\n0\n0\n1\n0\n0\n");
  write_file("T.txt", "0\n0\n1\n0\n0\n0\n");
  write_file("f.txt", "0\n0\n0.1\n-1\n0\n0\n");
  write_file("X.csv", "0,0\n3,2\n6,0\n");
  write_file("nodes.csv", "2,0,1,3,2\n");
  write_file("short.csv", "0,0\n3,2\n");
  const char *const at[] = {"--HN @/N.txt --HT @/T.txt --nodes @/X.csv", "--nodes @/nodes.csv"};
  for (int k = 0; k < 2; k++) {
    char line[300];
    (void)snprintf(line, sizeof line,
                   "solve --stiffness @/K.txt %s --f @/f.txt --mu 0.5 --csv @/sums%d", at[k], k);
    ck_assert_msg(run(line) == 0, "%s", output);
    /* by hand: r = -f; M = 3 * 1 - 2 * (-0.1) */
    ck_assert_ptr_nonnull(
        strstr(output, "sum of the reactions: x -0.1 y 1; moment about the origin: z 3.2\n"));
    (void)snprintf(line, sizeof line, "sums%d/sums.csv", k);
    double F[2], M;
    ck_assert_int_eq(
        sscanf(contents(line), "body_from_0,F_x,F_y,M_z\n0,%lf,%lf,%lf", &F[0], &F[1], &M), 3);
    ck_assert(fabs(F[0] + 0.1) + fabs(F[1] - 1) + fabs(M - 3.2) <= 1e-9);
    (void)snprintf(line, sizeof line, "sums%d/answer.vtu", k);
    ck_assert_ptr_nonnull(
        strstr(contents(line), k ? "NumberOfPoints=\"1\"" : "NumberOfPoints=\"3\""));
    ck_assert_ptr_nonnull(strstr(contents(line), "\n3 2 0\n"));
    (void)snprintf(line, sizeof line, "sums%d/r.csv", k);
    ck_assert_ptr_nonnull(strstr(contents(line), "\n0,2,stick,0,"));
    (void)snprintf(line, sizeof line, "sums%d/surface.dat", k);
    ck_assert_ptr_nonnull(strstr(contents(line), " 2\n"));
  }
  /* node 1 on node 2, entries of H_N alike: the contact is at the first; K^-1 = (3 2; 2 4) / 4,
   * W = 3/4, q = -1/4 */
  write_file("N2.txt", "0\n1\n0\n-1\n0\n0\n");
  write_file("T2.txt", "1\n0\n-1\n0\n0\n0\n");
  write_file("f2.txt", "0\n-1\n0\n0\n0\n0\n");
  ck_assert_int_eq(run("solve --stiffness @/K.txt --HN @/N2.txt --HT @/T2.txt --nodes @/X.csv "
                       "--f @/f2.txt --mu 0.5 --csv @/pair"),
                   0);
  double r_n;
  const char *pair = strstr(contents("pair/r.csv"), "\n0,1,stick,");
  ck_assert_ptr_nonnull(pair);
  ck_assert_int_eq(sscanf(pair, "\n0,1,stick,%*[^,],%lf", &r_n), 1);
  ck_assert_double_eq_tol(r_n, 1. / 3, 1e-9);
  ck_assert_int_eq(run("solve --stiffness @/K.txt --HN @/N.txt --HT @/T.txt --f @/f.txt --mu 0.5"),
                   0);
  ck_assert_ptr_nonnull(strstr(output, "sum of the r_n: 1\n")); /* may be rigid bodies */
  ck_assert_int_eq(run("solve --stiffness @/K.txt --HN @/N.txt --nodes @/X.csv --f @/f.txt"), 0);
  ck_assert_ptr_nonnull(
      strstr(output, "sum of the reactions: x 0 y 1; moment about the origin: z 3\n"));
  ck_assert_int_eq(run("solve --stiffness @/K.txt --HN @/N.txt --HT @/T.txt --mu 0.5 --nodes "
                       "@/short.csv"),
                   2);
  ck_assert_ptr_nonnull(strstr(output, "has 2 rows, K has 6 unknowns: 2 for each node are wanted"));
}

TEST(bad_matrices_are_2) {
  static const char *const wrong[][2] = {
      {"--HN @/N.txt --f @/f.txt", "one of --stiffness"},
      {"--stiffness @/K.txt --flexibility @/K.txt --HN @/N.txt", "one of --stiffness"},
      {"--stiffness @/none --HN @/N.txt", "/none: does not exist"},
      {"--stiffness @/K.txt --f @/f.txt --mu 0", "one of --HN"},
      {"--stiffness @/K.txt --HN @/N.txt --HT @/N.txt", "give --mu, 0 for no friction"},
      {"--stiffness @/K.txt --HN @/N.txt --mu 0.3", "needs the tangents"},
      {"--stiffness @/K.txt --HN @/N.txt --HT @/N.txt --mu nan", "--mu: friction is nan"},
      {"--stiffness @/K.txt --HN @/N.txt --HT @/N.txt --mu -1", "--mu: friction is -1"},
      {"--stiffness @/K.txt --HN @/three.txt", "has 3 rows, must have 2"},
      {"--stiffness @/three.txt --HN @/N.txt", "must be square"},
      {"--stiffness @/words.txt --HN @/N.txt", "line 2, 'two'"},
      {"--stiffness @/ragged.txt --HN @/N.txt", "line 2 has 1 number,"},
      {"--stiffness @/empty.txt --HN @/N.txt", "holds no number"},
      {"--stiffness @/K.txt --HN @/N.txt --f @/three.txt", "must hold 2"},
      {"--stiffness @/K.txt --HN @/N.txt --f @/row.txt", "must hold 2"},
      {"--stiffness @/K.txt --HN @/N.txt --g @/three.txt", "--g:"},
      {"--stiffness @/K.txt --HN @/N.txt --HT @/N.txt --mu @/three.txt",
       "holds 3 numbers, must hold 1"},
      {"--stiffness @/K.txt --H @/K.txt --mu 0.1 --dim 3", "does not divide"},
      {"--stiffness @/K.txt --H @/K.txt --mu 0.1 --dim 4", "is not 1, 2 or 3"},
      {"--stiffness @/K.txt --HN @/N.txt --dim 1", "--dim: 1 goes with --W"},
      {"--stiffness @/K.txt --nodes @/far.txt --mu 0.1", "no node 2"},
      {"--stiffness @/K.txt --nodes @/flat.txt --mu 0.1", "has no normal"},
      {"--stiffness @/K.txt --nodes @/f.txt --mu 0.1", "2 columns"},
      {"--stiffness @/lower.txt --HN @/N.txt", "is a lower triangle"},
      {"--stiffness @/lower.txt --HN @/N.txt", "says 'symmetric'"},
      {"--stiffness @/upper.txt --HN @/N.txt", "is an upper triangle"},
      {"--stiffness @/upper.mtx --HN @/N.txt", "is an upper triangle"},
      {"--W @/K.txt --mu 0.1", "--W: needs --q"},
      {"--W @/K.txt --q @/f.txt --mu 0.1 --f @/f.txt", "--W: goes with"},
      {"--W @/K.txt --q @/three.txt --mu 0.1 --dim 2", "must hold 2"},
      {"--W @/K.txt --q @/broken.npy --mu 0.1 --dim 2", "no array of real numbers"},
      {"--W @/K.txt --q @/zip.npz --mu 0.1 --dim 2", "a sparse matrix, no vector"},
      {"--stiffness @/zip.npz --HN @/N.txt", "write an array by numpy.save"},
      {"--flexibility @/K.txt --HN @/N.txt --on=K", "is for --stiffness"},
      {"--stiffness @/K.txt --HN @/N.txt --json --print", "--print"},
      {"--stiffness @/K.txt --HN @/N.txt -v --csv /dev/null/x", "/dev/null/x"},
  };
  write_file("K.txt", "3 1\n1 2\n");
  write_file("lower.txt", "3 0\n1 2\n");
  write_file("upper.mtx",
             "%%MatrixMarket matrix coordinate real general\n2 2 3\n1 1 3\n1 2 1\n2 2 2\n");
  write_file("upper.txt", "3 1\n0 2\n");
  write_file("N.txt", "0\n1\n");
  write_file("f.txt", "5 -10\n");
  write_file("three.txt", "1\n2\n3\n");
  write_file("row.txt", "1 2 3\n");
  write_file("words.txt", "1 2\ntwo 3\n");
  write_file("ragged.txt", "1 2\n3\n");
  write_file("empty.txt", "# nothing\n");
  write_file("far.txt", "2 0 1\n");
  write_file("flat.txt", "1 0 0\n");
  write_file("zip.npz", "PK\3\4 and so on");
  write_file("broken.npy", "\x93NUMPY\1");
  for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
    char arguments[300];
    (void)snprintf(arguments, sizeof arguments, "solve %s", wrong[k][0]);
    ck_assert_msg(run(arguments) == 2 && strstr(output, wrong[k][1]), "%s: %s", arguments, output);
  }
}

/* The last line says how it ended; --quiet leaves it alone, --verbose tells the way on stderr. */
TEST(last_line) {
  ck_assert_int_eq(run("solve -q " TEST_DATA "/failures/c20-scales.txt"), 0);
  ck_assert_str_eq(output, "solved\n");
  ck_assert_int_eq(run("solve -q " TEST_DATA "/failures/c03-jam-above.txt"), 1);
  ck_assert(strncmp(output, "not solved: ", 12) == 0);
  ck_assert_int_eq(run("solve " TEST_DATA "/failures/l01-cycling.txt"), 0);
  ck_assert(ends_in("\nsolved\n"));
  ck_assert_int_eq(run("solve -q " TEST_DATA "/failures/l05-no-solution.txt"), 1);
  ck_assert_str_eq(output, "not solved: no solution exists\n");
  ck_assert_int_eq(run("solve -v " TEST_DATA "/failures/c20-scales.txt"), 0);
  ck_assert(strstr(output, "s of CPU, residual") != NULL && ends_in("\nsolved\n"));
  ck_assert_int_eq(run("solve --json " TEST_DATA "/failures/c20-scales.txt"), 0);
  ck_assert(ends_in("\n}\n"));
}

/* Reactions beyond what rounding tells, positions exact: solved, and no candidate is at fault.
 * Sweeps alone do not get there. */
TEST(entries_of_all_sizes) {
  write_file("W.txt", "2 0 .5 0\n0 2 0 .5\n1.8e-307 1.4e195 1.9e-57 3.5e-152\n"
                      "2.7e-315 1.8e-307 4.8e-320 5.8e-275\n");
  write_file("q.txt", "-1\n.5\n-1\n0\n");
  ck_assert_int_eq(run("solve --W @/W.txt --q @/q.txt --mu .3 --dim 2"), 0);
  ck_assert(ends_in("\nsolved\n") && !strstr(output, "the error is at"));
  ck_assert_int_eq(run("solve --W @/W.txt --q @/q.txt --mu .3 --dim 2 -m nlgs"), 1);
  ck_assert(strstr(output, "the error is at candidate") && !strstr(output, "sweeps diverge"));
}

/* A spring of two nodes that is pulled away from its only contact. */
TEST(a_free_body_moves) {
  write_file("K.txt", "1 -1\n-1 1\n");
  write_file("N.txt", "0\n1\n");
  write_file("f.txt", "0\n5\n");
  ck_assert_int_eq(run("solve --stiffness @/K.txt --HN @/N.txt --f @/f.txt --mu 0"), 1);
  ck_assert_ptr_nonnull(strstr(output, "no equilibrium (proved). Nothing holds a body"));
  ck_assert_ptr_nonnull(strstr(output, "the body of unknown 0 moves"));
}

/* A box of width 1 and weight 1 on the floor, K = 0, pushed at its foot: it slides at mu. Held by a
 * spring it carries all. */
TEST(limit) {
  write_file(
      "N.mtx",
      "%%MatrixMarket matrix coordinate real general\n3 2 4\n2 1 1\n3 1 -.5\n2 2 1\n3 2 .5\n");
  write_file("T.mtx", "%%MatrixMarket matrix coordinate real general\n3 2 2\n1 1 1\n1 2 1\n");
  write_file("K.mtx", "%%MatrixMarket matrix coordinate real symmetric\n3 3 0\n");
  write_file("H.mtx",
             "%%MatrixMarket matrix coordinate real symmetric\n3 3 3\n1 1 9\n2 2 9\n3 3 9\n");
  write_file("f.txt", "0\n-1\n0\n");
  write_file("f1.txt", "1\n0\n0\n");
#define LIMIT " --HN @/N.mtx --HT @/T.mtx --f @/f.txt --mu .4 --limit @/f1.txt "
  ck_assert_int_eq(run("solve --stiffness @/K.mtx" LIMIT), 0);
  ck_assert(strstr(output, "carried at 0.39999") && strstr(output, "refused at 0.4") &&
            strstr(output, "a motion proves") && ends_in("\nsolved\n"));
  ck_assert_int_eq(run("solve --json --stiffness @/K.mtx" LIMIT), 0);
  ck_assert(strstr(output, "\"proved\": true") && strstr(output, "\"carried\": 0.39999"));
  ck_assert_int_eq(run("solve --stiffness @/H.mtx" LIMIT), 0);
  ck_assert(strstr(output, "nothing is refused up to inf"));
  ck_assert_int_eq(run("solve --print --stiffness @/K.mtx" LIMIT), 2);
  ck_assert_int_eq(run("solve jean-fig3 --limit @/f1.txt"), 2);
  ck_assert_int_eq(run("solve --stiffness @/K.mtx" LIMIT "--limit @/N.mtx"), 2);
}

int main(void) {
  return run_tests("matrices", make_directory, remove_directory);
}
