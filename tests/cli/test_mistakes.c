/* test_mistakes.c: mistakes that people make, each with an answer that says what to do; one meaning
 * per short option; JSON from every command. */
#define _GNU_SOURCE

#include "program.h"
#include "run.h"

/* The point of docs/tour.md, pushed down and to the right, and variants with one thing wrong. */
static void write_matrices(void) {
  write_file("K.mtx", "%%MatrixMarket matrix array real general\n2 2\n3\n1\n1\n2\n"); /* 3 1; 1 2 */
  write_file("K.txt", "3 1\n1 2\n");
  write_file("K3.txt", "2 0 0\n0 2 0\n0 0 2\n");
  write_file("N.txt", "0\n1\n");
  write_file("T.txt", "1\n0\n");
  write_file("f.txt", "5\n-10\n");
  write_file("long.txt", "0\n3\n");
  write_file("leaning.txt", "1\n0.5\n");
  write_file("up.txt", "0\n10\n");
  write_file("left.txt", "-10\n0\n");
  write_file("straight.txt", "2 0\n0 2\n");
  write_file("N3.txt", "0\n0\n1\n");
  write_file("T3.txt", "1 0\n0 1\n0 0\n");
  write_file("box.txt", "1 0 0\n0 1 0\n0 0 0.16666666666666666\n");
  write_file("zero.txt", "0 0 0\n0 0 0\n0 0 0\n");
  write_file("boxN.txt", "0 0\n1 1\n-0.5 0.5\n");
  write_file("boxT.txt", "1 1\n0 0\n0.5 0.5\n");
  write_file("boxf.txt", "1\n-10\n0\n");
  write_file("W.txt", "2 0\n0 2\n");
  write_file("q.txt", "-1\n0\n");
  write_file("W6.txt",
             "1 0 0 0 0 0\n0 1 0 0 0 0\n0 0 1 0 0 0\n0 0 0 1 0 0\n0 0 0 0 1 0\n0 0 0 0 0 1\n");
  write_file("mu.txt", "-0.5\n");
  write_file("matlab.txt", "1 1 3\n1 2 1\n2 1 1\n2 2 2\n3 3 1\n");
  write_file("K.mat", "MATLAB 5.0 MAT-file, Platform: GLNXA64");
  write_file("K.dmig", "DMIG    KAAX           0       6       2       0\n");
  write_file("comma.txt", "3,0 1,5\n1,5 2,0\n");
  write_file("gap.txt", "0,5\n0,1\n");
}

#define POINT "solve --stiffness=@/K.txt --HN=@/N.txt --HT=@/T.txt --f=@/f.txt "

/* What was typed, the exit status, and what the answer has to say. */
static const struct {
  const char *typed;
  int status;
  const char *answer;
} mistakes[] = {
    {"solev @/K.mtx", 2, "'solev' is no command; did you mean solve?"},
    {"help", 0, "Usage: delassus COMMAND"},
    {"help solve", 0, "Usage: delassus solve"},
    {"help sovle", 2, "did you mean solve?"},
    {"jean-fig3", 2, "'jean-fig3' is a scene: delassus scene jean-fig3"},
    {"data/failures/c20-scales.txt", 2, "is a file: delassus solve data/failures/c20-scales.txt"},
    {"scene jean", 2, "did you mean jean-fig3, jean-fig4, jean-moving or jean-moving4?"},
    {"scene idnentation", 2, "did you mean indentation?"},
    {"scene bar", 2, "did you mean bar-impact, bar-bounce or bar-fixed?"},
    {"chart jean-fig", 2, "no file and no scene; did you mean jean-fig3 or jean-fig4?"},
    {"solve jean-fig5", 2, "jean-fig5: no file and no scene; did you mean jean-fig3 or jean-fig4?"},
    {"solve --stifness=@/K.mtx", 2, "--stifness: is no option; did you mean --stiffness?"},
    {"scene jean-fig3 --wieghted", 2, "--wieghted: is no option; did you mean --weighted?"},
    {"solve --st=@/K.txt", 2, "--st: is no option; did you mean --stiffness or --step?"},
    {"solve -m nwton @/K.mtx", 2, "--method: 'nwton' is no method; did you mean newton?"},
    {"solve -m x @/K.mtx", 2, "'x' is no method; these are: auto, nlgs, lemke"},
    {"scene indentation -m newtn", 2, "did you mean newton?"},
    {"scene bar-impact -m newtn", 2, "did you mean newton?"},
    {"map indentation -m nlsg -o @/map", 2, "did you mean nlgs?"},
    {"solve -a andersen @/K.mtx", 2, "did you mean anderson?"},
    {"solve @/K.mtx", 2, "/K.mtx is a Matrix Market file: use --stiffness"},
    {"solve @/K.txt", 2, "/K.txt is a table of numbers: use --stiffness"},
    {"info @/K.mtx", 2, "/K.mtx is a Matrix Market file: use --stiffness"},
    {"chart @/K.mtx -o @/c", 2, "K.mtx is a Matrix Market file: use --stiffness"},
    {"solve --stiffness=data/fclib/CubeH8.hdf5 --HN=@/N.txt", 2,
     "this is an HDF5 file, no matrix: a problem of FCLIB goes as delassus solve FILE"},
    {"solve --lcp @/K.mtx", 2, "q is missing: delassus solve --lcp"},
    {"solve --lcp data/failures/l01-cycling.txt", 0, "LCP of 3 unknowns"},
    {"solve --lcp data/failures/c20-scales.txt", 2, "a contact problem goes without --lcp"},
    {POINT "--mu 0,3", 2, "--mu: '0,3' is not a number; write the decimal point as '.': 0.3"},
    {POINT "--mu abc", 2, "--mu: 'abc' is neither a number nor a file"},
    {POINT "--mu nan", 2, "--mu: friction is nan, must be a number >= 0"},
    {POINT "--mu -0.3", 2, "--mu: friction is -0.3, must be a number >= 0"},
    {POINT "--mu @/mu.txt", 2, "the friction of contact 0 is -0.5, must be a number >= 0"},
    {"scene jean-fig3 --mu 0,3", 2, "write the decimal point as '.': 0.3"},
    {"scene jean-fig3 --mesh 4294967298x2", 2, "is not NXxNY, two whole numbers >= 1"},
    {"scene jean-fig3 --mesh 2x4294967298", 2, "is not NXxNY, two whole numbers >= 1"},
    {"scene indentation --mesh 4294967298x2", 2, "is not NXxNY, two whole numbers >= 1"},
    {"scene block-drop --mesh 4294967298", 2, "is neither N nor NXxNY, whole numbers >= 1"},
    {"scene block-drop --mesh 2x", 2, "is neither N nor NXxNY, whole numbers >= 1"},
    {"scene block-drop --steps 4294967298", 2, "is not a whole number from 1 to 1000000000"},
    {"scene jean-block --load 1,2,3,4", 2, "is not TOP,SIDE or TOP,SIDE,SIDE_TOP"},
    {"scene jean-block --load 1,2x", 2, "is not TOP,SIDE or TOP,SIDE,SIDE_TOP"},
    {"scene jean-fig3 --mu nan", 2, "--mu: 'nan' is not a number >= 0"},
    {POINT "--mu .2 --g abc", 2, "--g: 'abc' is neither a number nor a file"},
    {"solve --W=@/W.txt --q=@/q.txt --mu .3", 0, "solved"}, /* d = 2: the size says it */
    {"solve --W=@/W6.txt --q=@/q.txt --mu .3", 2,
     "--dim: 2 or 3 is wanted: 6 columns of H or rows of W fit both"},
    /* what is not given is said, with what it means */
    {"solve --stiffness=@/K.txt --HN=@/N.txt --HT=@/T.txt --mu .2", 0,
     "no loads: --f is not given"},
    {"solve --stiffness=@/K.txt --HN=@/N.txt --f=@/f.txt", 0, "no friction: --HT is not given"},
    {"solve --stiffness=@/K.txt --HN=@/N.txt --f=@/f.txt", 0, "free 0, touching 1"},
    {"chart --stiffness=@/K.txt --HN=@/N.txt -r 1 -o @/chart", 0,
     "no loads: --f is not given; no friction: --HT is not given"},
    {"solve --W=@/W.txt --q=@/q.txt --mu .3", 0, "2D: 2 rows of --W for 1 contact"},
    {"solve --stiffness=@/K.txt --H=@/K.txt --f=@/f.txt --mu .2", 0,
     "2D: 2 columns of --H for 1 contact"},
    {"solve --stiffness=@/K.txt --HN=@/N.txt --HT=@/T.txt --mu @/q.txt", 2,
     "holds 2 numbers, must hold 1"},
    /* files of others */
    {"solve nosuch.hdf5", 2, "delassus: nosuch.hdf5: does not exist\n"},
    {"solve --stiffness=@ --HN=@/N.txt", 2, "is a directory"},
    {"solve --stiffness=@/matlab.txt --HN=@/N.txt", 2, "use --triplets"},
    {"solve --stiffness=@/K.mat --HN=@/N.txt", 2, "[i,j,x] = find(K)"},
    {"solve @/K.mat", 2, "[i,j,x] = find(K)"},
    {"solve --stiffness=@/K.dmig --HN=@/N.txt", 2, "Nastran (DMIG): write lines"},
    {"solve --stiffness=@/comma.txt --HN=@/N.txt", 2, "has decimal commas; numbers have a point"},
    {POINT "--mu .2 --g @/gap.txt", 2, "its commas are read as separators; a decimal has a point"},
    /* names with a line each */
    {"help methods", 0, "admm "},
    {"help scenes", 0, "jean-fig3     "},
    /* plausible and wrong: a hint, and an answer all the same */
    {"solve --stiffness=@/K.txt --HN=@/long.txt --HT=@/T.txt --f=@/f.txt --mu .2", 0,
     "hint: H_N: the normal of contact 0 has length 3"},
    {"solve --stiffness=@/K.txt --HN=@/N.txt --HT=@/leaning.txt --f=@/f.txt --mu .2", 0,
     "hint: H_T: the tangent of contact 0 is not perpendicular to its normal"},
    {POINT "--mu .2 --g -0.1", 0, "hint: --g: all gaps are negative (the least -0.1)"},
    {"solve --stiffness=@/K.txt --HN=@/N.txt --HT=@/T.txt --f=@/up.txt --mu .2", 0,
     "hint: nothing presses although unknowns are loaded"},
    {"solve --stiffness=@/straight.txt --HN=@/N.txt --HT=@/T.txt --f=@/left.txt --mu .2", 0,
     "are H_N and H_T exchanged?"},
    {"solve --stiffness=@/K3.txt --HN=@/T3.txt --HT=@/N3.txt --mu .2", 2,
     "are --HN and --HT exchanged?"},
    {"scene jean-fig3 --young 1e3", 0, "exceeds the size of the body, 0.004: check the units"},
};
enum { MISTAKES = sizeof mistakes / sizeof mistakes[0] };

TEST_EACH(a_mistake_and_its_answer, 0, MISTAKES) {
  write_matrices();
  const int status = run(mistakes[_i].typed);
  ck_assert_msg(strstr(output, mistakes[_i].answer) && status == mistakes[_i].status,
                "%s: status %d, no \"%s\" in %s", mistakes[_i].typed, status, mistakes[_i].answer,
                output);
}

/* A right input gets no hint. */
TEST(no_hint_without_a_reason) {
  write_matrices();
  static const char *const right[] = {
      POINT "--mu .2", POINT "--mu .2 --g 0.1", POINT "--mu inf",
      "solve --stiffness=@/K3.txt --HN=@/N3.txt --HT=@/T3.txt --mu .2", "scene jean-fig3",
      "scene jean-fig4 --weighted",
      /* rigid bodies: rotations are no lengths */
      "solve --stiffness=@/box.txt --HN=@/boxN.txt --HT=@/boxT.txt --f=@/boxf.txt --mu .5",
      "solve --stiffness=@/zero.txt --HN=@/boxN.txt --HT=@/boxT.txt --f=@/boxf.txt --mu .5"};
  for (size_t k = 0; k < sizeof right / sizeof right[0]; k++) {
    ck_assert_int_eq(run(right[k]), 0);
    ck_assert_msg(!strstr(output, "hint:"), "%s: %s", right[k], output);
  }
  ck_assert_int_eq(run("solve --stiffness=@/K.txt --HN=@/N.txt --HT=@/T.txt --f=@/up.txt --mu .2 "
                       "--quiet"),
                   0);
  ck_assert_str_eq(output, "solved\n");
}

/* Each short option stands for one long one, in all commands. */
TEST(short_options_mean_one_thing) {
  static const char *const commands[] = {"scene --help",
                                         "scene indentation --help",
                                         "scene bar-impact --help",
                                         "solve --help",
                                         "info --help",
                                         "chart --help",
                                         "map --help",
                                         "profile --help",
                                         "study --help"};
  char meaning[128][40] = {{0}};
  int found = 0;
  for (size_t k = 0; k < sizeof commands / sizeof commands[0]; k++) {
    ck_assert_int_eq(run(commands[k]), 0);
    ck_assert_msg(strstr(output, "-j, --json"), "%s: no --json", commands[k]);
    for (const char *at = output; (at = strstr(at, "\n  -")); at++) {
      char letter, name[40];
      if (sscanf(at, "\n  -%c, --%39[a-z-]", &letter, name) != 2) continue;
      char *known = meaning[letter & 127];
      ck_assert_msg(!*known || !strcmp(known, name), "%s: -%c is --%s and --%s", commands[k],
                    letter, known, name);
      strcpy(known, name);
      found++;
    }
  }
  ck_assert_int_gt(found, 60);
}

/* --json: one object and nothing else on stdout. */
static const char *const spoken[] = {
    "scene jean-fig3",
    "scene bar-impact --mesh 10",
    "scene indentation -n 2 --mesh 4x4",
    "solve data/failures/c20-scales.txt",
    "solve --lcp data/failures/l01-cycling.txt",
    "info data/failures/c20-scales.txt",
    "chart jean-fig3 -r 1 -o @/chart",
    "map jean-fig3 --rows 2 -o @/map",
    "profile -r 1 jean-fig3 -o @/profile",
    "study jean-fig3 -o @/study",
    "map bar-impact --against mesh --rows 1 --mu 0:1 -m nlgs --limit .2 -o @/steps"};

enum { SPOKEN = sizeof spoken / sizeof spoken[0] };

TEST_EACH(json_of_every_command, 0, SPOKEN) {
  char arguments[200];
  (void)snprintf(arguments, sizeof arguments, "%s --json 2>/dev/null", spoken[_i]);
  ck_assert_int_le(run(arguments), 1);
  int depth = 0, objects = 0;
  for (const char *at = output; *at; at++) {
    if (*at == '"') do
        at += at[1] == '\\' ? 2 : 1;
      while (*at && *at != '"');
    depth += (*at == '{' || *at == '[') - (*at == '}' || *at == ']');
    objects += depth == 0 && *at == '}';
    ck_assert_msg(depth > 0 || *at == '}' || *at == '\n', "%s: %s", arguments, at);
  }
  ck_assert_msg(depth == 0 && objects == 1 && !strstr(output, "nan"), "%s: %s", arguments, output);
  if (strncmp(spoken[_i], "info", 4) != 0) ck_assert_ptr_nonnull(strstr(output, "\"status\": \""));
}

int main(void) {
  return run_tests("mistakes", make_directory, remove_directory);
}
