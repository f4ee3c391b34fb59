/*
 * test_cpp.cpp: delassus.hpp: answers, sizes, exceptions through C, objects that move.
 */
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>

#include "delassus.hpp"

static int failures;

static void expect(bool good, const char *text, int line) {
  if (good) return;
  std::printf("tests/languages/test_cpp.cpp:%d: %s\n", line, text);
  failures++;
}
#define EXPECT(condition) expect(condition, #condition, __LINE__)

/* Returns the status and the argument of the error that f throws, "" for none. */
template <class F> static std::string refusal(F &&f) {
  try {
    f();
  } catch (const delassus::error &e) {
    return std::string(dls_status_name(e.status())) + " " + e.argument();
  }
  return "";
}

static bool near(double a, double b) {
  return std::fabs(a - b) <= 1e-8 * std::fabs(b);
}

static const std::vector<double> W = {1e-3, 0, 0, 1e-3}, q = {-2e-3, 3e-3}, mu = {0.5};

static void solves() {
  const dls_contact problem = delassus::contact(2, W, q, mu);
  const delassus::answer a = delassus::solve(problem);
  EXPECT(a.solved());
  EXPECT(std::string(a.text()) == "solved");
  EXPECT(near(a.r[0], 2) && near(a.r[1], -1) && near(a.u[1], 2e-3)); /* as hello_contact.c */
  EXPECT(delassus::states(problem, a)[0] == DLS_SLIP);
  EXPECT(delassus::certify(problem, a.r).residual <= 1e-8);
  EXPECT(near(delassus::certify(problem, {1, 0}).penetration, 1e-3));
  const std::vector<double> coupled = {1, 0.5, 0, 0.5, 1, 0, 0, 0, 1}, none = {0, 0, 0};
  std::vector<double> load, one, two;
  const dls_fold fold = delassus::fold(delassus::contact(3, coupled, none, mu), &load, &one, &two);
  EXPECT(near(fold.unique, 2) && fold.friction >= 2 && fold.friction < 2 + 4e-6 && one != two);
  EXPECT(load.size() == 3 && std::isinf(delassus::fold(problem).unique));
  delassus::solver first(2, 3, delassus::settings("newton"));
  delassus::solver second = std::move(first);
  EXPECT(near(second.solve(problem).r[0], 2));
  EXPECT(near(second.map({-1, 0})[2], 2) && near(second.map({-1, 0})[0], 0));
  EXPECT(first.get() == nullptr && second.get() != nullptr);
  const delassus::answer warm = delassus::solve(problem, delassus::settings("nlgs"), a.r);
  EXPECT(warm.solved() && warm.r == a.r);
  EXPECT(delassus::solve(delassus::contact(3, {}, {}, {})).solved());
}

static void refuses() {
  const dls_contact problem = delassus::contact(2, W, q, mu);
  EXPECT(refusal([&] { (void)delassus::contact(4, W, q, mu); }) == "DLS_E_ARGUMENT d");
  EXPECT(refusal([&] { (void)delassus::contact(2, {1}, q, mu); }) == "DLS_E_SIZE W");
  EXPECT(refusal([&] { (void)delassus::contact(2, W, {1}, mu); }) == "DLS_E_SIZE q");
  EXPECT(refusal([&] { (void)delassus::contact(2, W, q, {}); }) == "DLS_E_SIZE q");
  EXPECT(refusal([&] { (void)delassus::solver(2, 1).map({0}); }) == "DLS_E_ARGUMENT from");
  EXPECT(refusal([&] { delassus::settings s("no such"); }) == "DLS_E_ARGUMENT name");
  EXPECT(refusal([&] { (void)delassus::certify(problem, {1}); }) == "DLS_E_SIZE r");
  EXPECT(refusal([&] { (void)delassus::solve(problem, {}, {1}); }) == "DLS_E_SIZE start");
  delassus::settings wrong;
  wrong.limits.tol = -1;
  EXPECT(refusal([&] { (void)delassus::solve(problem, wrong); }) == "DLS_E_ARGUMENT limits.tol" ||
         refusal([&] { (void)delassus::solve(problem, wrong); }) == "DLS_E_ARGUMENT tol");
  const std::vector<double> bad = {-2e-3, std::nan("")};
  try {
    (void)delassus::solve(delassus::contact(2, W, bad, mu));
    EXPECT(false);
  } catch (const delassus::error &e) {
    EXPECT(e.status() == DLS_E_NOT_FINITE && e.argument() == "q" && e.index() == 1);
    EXPECT(e.function() == "dls_solve" && std::isnan(e.value()));
  }
}

/* A chain that couples all candidates, so that no method ends at once. */
static void calls_back() {
  const int nc = 30;
  const std::size_t m = 60;
  std::vector<double> A(m * m), b(m), friction(30, 0.4);
  for (std::size_t i = 0; i < m; i++) {
    for (std::size_t j = 0; j < m; j++)
      A[i + j * m] = 1 + static_cast<double>(i < j ? i : j);
    b[i] = i % 2 ? 0.5 : -1 - static_cast<double>(i % 7);
  }
  const dls_contact problem = delassus::contact(2, A, b, friction);
  int calls = 0;
  bool ended = false;
  const delassus::answer a = delassus::solve(problem, {}, {}, [&](const dls_progress &p) {
    calls++;
    ended = ended || p.last;
    return false;
  });
  EXPECT(a.solved() && calls > 1 && ended && problem.nc == nc);
  const auto stop = [](const dls_progress &) { return true; };
  EXPECT(delassus::solve(problem, {}, {}, stop).status == DLS_CANCELLED);
  bool thrown = false;
  try {
    (void)delassus::solve(problem, {}, {},
                          [](const dls_progress &) -> bool { throw std::out_of_range("mine"); });
  } catch (const std::out_of_range &e) {
    thrown = std::string(e.what()) == "mine";
  }
  EXPECT(thrown);
}

static void reduces() {
  const double K[] = {3, 1, 1, 2};
  const delassus::sparse HN{2, 1, {0, 1}, {1}, {1}}, HT{2, 1, {0, 1}, {0}, {1}};
  dls_model model = delassus::model(2, {2, 2, 2, K}, HN, HT);
  delassus::reduction R(model);
  R.load({5, -10});
  const std::vector<double> friction = {0.2};
  const delassus::answer a = delassus::solve(R.contact(friction));
  EXPECT(near(a.r[0], 10.9375) && near(a.r[1], -2.1875)); /* docs/tour.md */
  EXPECT(near(R.recover(a.r)[0], 0.9375));
  EXPECT(R.nodal(a.r) == a.r && R.info().W_bytes > 0);
  EXPECT(near(R.solve(friction).x[0], 0.9375) && R.motion().empty());
  EXPECT(R.states(friction, a).at(0) == DLS_SLIP);
  EXPECT(R.certify(friction, a.r, R.recover(a.r)).residual <= 1e-8);
  EXPECT(refusal([&] { (void)R.certify(friction, a.r, {1}); }) == "DLS_E_SIZE x");
  EXPECT(refusal([&] { (void)delassus::solve_model(model, {1}, {}, friction); }) == "DLS_E_SIZE f");
  EXPECT(refusal([&] { (void)delassus::solve_model(model, {}, {1}, friction); }) == "DLS_E_SIZE g");
  EXPECT(refusal([&] { (void)delassus::solve_model(model, {}, {}, {1, 2}); }) == "DLS_E_SIZE mu");
  R.load_free({4, -7});
  EXPECT(near(R.contact(friction).q[0], -7));
  EXPECT(refusal([&] { R.load({1}); }) == "DLS_E_SIZE f");
  EXPECT(refusal([&] { R.load({}, {1}); }) == "DLS_E_SIZE g");
  EXPECT(refusal([&] { (void)R.recover({1}); }) == "DLS_E_SIZE r");
  EXPECT(refusal([&] { (void)R.contact({1, 2}); }) == "DLS_E_SIZE mu");
  model.n = 0;
  EXPECT(refusal([&] { delassus::reduction none(model); }) != "");
}

/* A node at a quarter of an edge, held by springs of 1, is pressed on it; then on its other end. */
static void finds_pairs() {
  const double X[] = {0, 0, 4, 0, 1, 0.5}, low[] = {0, 0, 4, 0, 0, 0.5};
  const int node[] = {2}, face[] = {1, 0};
  dls_surfaces s = {};
  s.d = 2;
  s.n = 6;
  s.points = 3;
  s.X = X;
  s.nodes = s.faces = 1;
  s.node = node;
  s.corners = 2;
  s.face = face;
  const delassus::pairs pairs(s);
  EXPECT(pairs.get().nodes == 1 && pairs.g()[0] == 0.5 && pairs.g()[1] == 0);
  const delassus::sparse K{6, 6, {0, 1, 2, 3, 4, 5, 6}, {0, 1, 2, 3, 4, 5}, {1, 1, 1, 1, 1, 1}};
  dls_model model = {};
  model.d = 2;
  model.n = 6;
  model.operator_kind = DLS_STIFFNESS_SPARSE;
  model.factorization = DLS_CHOLESKY;
  model.Ks = K.view();
  pairs.into(&model);
  delassus::reduction reduction(model);
  std::vector<double> x;
  reduction.load({0, 0, 0, 0, 0, -2}, pairs.g());
  delassus::answer a = reduction.solve({0}, &x);
  EXPECT(a.solved() && near(a.r[0], 1.5 / 1.625)); /* 1 + 9/16 + 1/16 */
  s.X = low;
  const delassus::pairs there(s);
  there.into(&model);
  reduction.move(model, there.g());
  a = reduction.solve({0}, &x);
  EXPECT(a.solved() && near(a.r[0], 0.75) && near(x[5], -1.25));
  EXPECT(refusal([&] { reduction.move(model, {1}); }) == "DLS_E_SIZE g");
  s.corners = 3;
  EXPECT(refusal([&] { delassus::pairs none(s); }) == "DLS_E_ARGUMENT corners");
}

/* The point once more, its K sparse, from entries in any order; the columns of H dense. */
static void gathers() {
  delassus::entries K(2);
  delassus::sparse HN, HT;
  const double x[] = {1, 0}, y[] = {0, 1};
  HN.rows = HT.rows = 2;
  HN.append(y);
  HT.append(x);
  K.add(1, 1, 1.5);
  K.add(0, 1, 1);
  K.add(0, 0, 3);
  K.add(1, 0, 1);
  K.add(1, 1, 0.5);
  const delassus::sparse Ks = K.columns(2);
  EXPECT((Ks.p == std::vector<int>{0, 2, 5} && HN.i == std::vector<int>{1} && HN.cols == 1));
  const delassus::answer a =
      delassus::solve_model(delassus::model(2, Ks, HN, HT), {5, -10}, {}, {0.2});
  EXPECT(a.solved() && near(a.r[0], 10.9375) && near(a.x[0], 0.9375) && near(a.u[1], 0.9375));
  EXPECT(refusal([&] { K.add(2, 0, 1); }) == "DLS_E_ARGUMENT row");
  EXPECT(refusal([&] { (void)K.columns(1); }) == "DLS_E_ARGUMENT cols");
}

/* A spring that nothing holds: pressed on the stop; pulled off it, the motion (1, 1) proves it. */
static void flies() {
  const double K[] = {5, -5, -5, 5};
  const delassus::sparse HN{2, 1, {0, 1}, {0}, {1}}, HT{2, 1, {0, 0}, {}, {}};
  const dls_model model = delassus::model(2, {2, 2, 2, K}, HN, HT);
  for (const dls_on on : {DLS_ON_EITHER, DLS_ON_K}) {
    delassus::reduction_settings s;
    s.on = on;
    delassus::reduction R(model, s);
    EXPECT(R.info().on == DLS_ON_K);
    R.load({0, -10});
    std::vector<double> x;
    EXPECT(R.solve({0}, &x).solved() && near(x[1], -2));
    R.load({0, 10});
    EXPECT(R.solve({0}).status == DLS_NO_SOLUTION);
    const std::vector<double> b = R.motion();
    EXPECT(b.size() == 2 && b[0] == b[1] && b[1] > 0);
    EXPECT(refusal([&] { (void)R.recover({0, 0}); }) == "DLS_E_UNSUPPORTED reduction");
    std::vector<double> mover;
    const dls_limit limit = R.limit({0, 1}, {0}, {0, -10}, {}, nullptr, nullptr, &x, &mover);
    EXPECT(limit.proved && limit.carried <= 10 && limit.refused >= 10 - 1e-9);
    EXPECT(limit.refused - limit.carried <= 1e-5 && mover[0] == mover[1] && mover[1] > 0);
    EXPECT(refusal([&] { (void)R.limit({0}, {0}); }) == "DLS_E_SIZE f1");
  }
}

/* A ball of mass 1 falls freely, then rests on the floor. */
static void moves() {
  const delassus::sparse M{2, 2, {0, 1, 2}, {0, 1}, {1, 1}};
  const delassus::sparse HN{2, 1, {0, 1}, {1}, {1}}, HT{2, 1, {0, 1}, {0}, {1}};
  const double gap[] = {0.05};
  dls_motion_model model = {};
  model.d = model.n = 2;
  model.nodes = 1;
  model.factorization = DLS_CHOLESKY;
  model.M = M.view();
  model.HN = HN.view();
  model.HT = HT.view();
  model.gap = gap;
  delassus::motion_settings s;
  EXPECT(refusal([&] { delassus::motion none(model, s); }) == "DLS_E_ARGUMENT h");
  s.h = 0.01;
  delassus::motion ball(model, s);
  for (int k = 0; k < 5; k++)
    EXPECT(ball.step({0, -10}) == DLS_OK);
  EXPECT(near(ball.state().v[1], -0.5));
  for (int k = 0; k < 30; k++)
    EXPECT(ball.step({0, -10}) == DLS_OK);
  EXPECT(near(ball.state().p[0], 0.1)); /* weight times h */
  EXPECT(std::fabs(ball.energies().residual) <= 1e-12 * ball.energies().scale);
  EXPECT(refusal([&] { (void)ball.step({1}); }) == "DLS_E_SIZE f");
}

int main() {
  solves();
  refuses();
  calls_back();
  reduces();
  finds_pairs();
  gathers();
  flies();
  moves();
  std::printf("C++: %s\n", failures ? "failed" : "passed");
  return failures != 0;
}
