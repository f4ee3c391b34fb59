/*
 * delassus.hpp: the library for C++17: objects that free themselves, std::vector in and out, errors
 * as exceptions. Header only; everything is that of delassus.h, which says what it means.
 *
 *   auto a = delassus::solve_model(model, f, g, mu);   K, H_N, H_T, f, g, mu -> a.r, a.u, a.x
 *
 *   delassus::reduction reduction(model);              the same for several loads on one K
 *   reduction.load(f, g);
 *   auto b = reduction.solve(mu);
 *
 * A status below 0 is thrown as delassus::error. A solve that stops early is no error:
 * answer.status says so, answer.r is the best one found. An exception of a progress function
 * cancels the solve and comes out of it.
 */
#ifndef DELASSUS_HPP
#define DELASSUS_HPP

#include <cstddef>
#include <exception>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "delassus.h"

namespace delassus {

/* A status below 0; what() is the message. */
class error : public std::runtime_error {
public:
  explicit error(const dls_error &e) : std::runtime_error(e.message), details(e) {}
  dls_status status() const noexcept {
    return details.status;
  }
  std::string function() const {
    return details.function;
  }
  std::string argument() const {
    return details.argument;
  }
  long long index() const noexcept {
    return details.index;
  }
  double value() const noexcept {
    return details.value;
  }

private:
  dls_error details;
};

/* Calls f(&error), throws a status below 0, returns the status. */
template <class F> dls_status call(F &&f) {
  dls_error e = {};
  const dls_status status = f(&e);
  if (status < 0) throw error(e);
  return status;
}

namespace detail {

[[noreturn]] inline void refuse(dls_status status, const char *function, const char *argument,
                                const std::string &text) {
  dls_error e = {};
  e.status = status;
  e.function = function;
  e.argument = argument;
  e.index = -1;
  const std::string message = std::string(function) + ": " + argument + ": " + text;
  message.copy(e.message, sizeof e.message - 1);
  throw error(e);
}

/* Checks the size of a vector that C takes by its address; empty: NULL, where that is allowed. */
inline const double *pointer(const std::vector<double> &x, std::size_t size, const char *function,
                             const char *argument, bool optional) {
  if (x.empty() && (optional || size == 0)) return nullptr;
  if (x.size() != size)
    refuse(DLS_E_SIZE, function, argument,
           "has " + std::to_string(x.size()) +
               (x.size() == 1 ? " entry, needs " : " entries, needs ") + std::to_string(size));
  return x.data();
}

/* Holds a C object, which `destroy` frees. */
template <class T, void (*destroy)(T *)> struct deleter {
  void operator()(T *object) const noexcept {
    destroy(object);
  }
};
template <class T, void (*destroy)(T *)> using held = std::unique_ptr<T, deleter<T, destroy>>;

inline std::size_t size(int a, int b) {
  return static_cast<std::size_t>(a) * static_cast<std::size_t>(b);
}

} /* namespace detail */

/* ---- settings and answers -------------------------------------------------------------------- */

/* Settings of any method: fields of dls_solver_settings, filled with the defaults. */
struct settings : dls_solver_settings {
  settings() : dls_solver_settings() {
    dls_solver_settings_init(this);
  }
  /* "auto", "nlgs", "newton", ...; an unknown name is an error */
  explicit settings(const char *name) : settings() {
    if (!dls_method_find(name, &method))
      detail::refuse(DLS_E_ARGUMENT, "settings", "name", std::string("no method ") + name);
  }
};

/* The outcome of a solve. */
struct answer {
  dls_status status;        /* DLS_OK, DLS_TO_ROUNDING: solved; others above 0: stopped early */
  std::vector<double> r, u; /* d nc: reactions, local positions */
  std::vector<double> x;    /* n: unknowns, where a body is solved; else empty */
  dls_info info;
  bool solved() const noexcept {
    return dls_solved(status) != 0;
  }
  const char *text() const noexcept {
    return dls_status_text(status);
  }
};

/* Called repeatedly during a solve; returns true to cancel it. */
using progress = std::function<bool(const dls_progress &)>;

/* A sparse matrix by columns that owns its arrays. */
struct sparse {
  int rows = 0, cols = 0;
  std::vector<int> p{0}, i;
  std::vector<double> x;
  dls_sparse view() const {
    return {rows, cols, p.data(), i.data(), x.data()};
  }
  /* appends a column, all its rows; zeros are left out */
  void append(const double *column) {
    for (int k = 0; k < rows; k++)
      if (column[k] != 0) i.push_back(k), x.push_back(column[k]);
    p.push_back(static_cast<int>(i.size()));
    cols++;
  }
};

/* Entries of a matrix in any order; those of one place add up. */
class entries {
public:
  explicit entries(std::size_t count) : rows(count) {}
  void add(std::size_t row, std::size_t column, double value) {
    if (row >= rows) detail::refuse(DLS_E_ARGUMENT, "add", "row", "is " + std::to_string(row));
    i.push_back(static_cast<int>(row));
    j.push_back(column);
    x.push_back(value);
  }
  sparse columns(std::size_t cols) const {
    sparse A;
    A.rows = static_cast<int>(rows);
    A.cols = static_cast<int>(cols);
    std::vector<std::size_t> at(cols + 1);
    for (std::size_t column : j) {
      if (column >= cols)
        detail::refuse(DLS_E_ARGUMENT, "columns", "cols", "misses " + std::to_string(column));
      at[column + 1]++;
    }
    for (std::size_t c = 0; c < cols; c++)
      at[c + 1] += at[c];
    A.p.assign(at.begin(), at.end());
    A.i.resize(i.size());
    A.x.resize(i.size());
    for (std::size_t k = 0; k < i.size(); k++) {
      const std::size_t to = at[j[k]]++;
      A.i[to] = i[k];
      A.x[to] = x[k];
    }
    return A;
  }

private:
  std::size_t rows;
  std::vector<int> i;
  std::vector<std::size_t> j;
  std::vector<double> x;
};

/* Models of a host: d = 2 or 3, K dense or sparse, a column of HN for each contact, d - 1 of HT.
 * They are views: the arguments have to outlive them. */
inline dls_model model(int d, const dls_dense &K, const sparse &HN, const sparse &HT,
                       dls_factorization kind = DLS_CHOLESKY) {
  dls_model m = {};
  m.d = d;
  m.n = K.cols;
  m.nodes = HN.cols;
  m.operator_kind = DLS_STIFFNESS_DENSE;
  m.factorization = kind;
  m.K = K;
  m.HN = HN.view();
  m.HT = HT.view();
  return m;
}
inline dls_model model(int d, const sparse &K, const sparse &HN, const sparse &HT,
                       dls_factorization kind = DLS_CHOLESKY) {
  dls_model m = model(d, dls_dense{K.rows, K.cols, K.rows, nullptr}, HN, HT, kind);
  m.operator_kind = DLS_STIFFNESS_SPARSE;
  m.Ks = K.view();
  return m;
}

/* A view of a dense W (m x m by columns), q (m) and mu (nc), which have to outlive it. */
inline dls_contact contact(int d, const std::vector<double> &W, const std::vector<double> &q,
                           const std::vector<double> &mu) {
  if (d != 2 && d != 3) detail::refuse(DLS_E_ARGUMENT, "contact", "d", "is neither 2 nor 3");
  dls_contact problem = {};
  const std::size_t m = static_cast<std::size_t>(d) * mu.size();
  problem.d = d;
  problem.nc = static_cast<int>(mu.size());
  problem.q = detail::pointer(q, m, "contact", "q", false);
  problem.mu = mu.data();
  const int n = static_cast<int>(m);
  problem.W = {n, n, n > 0 ? n : 1, detail::pointer(W, m * m, "contact", "W", false)};
  return problem;
}

/* The certificate of r (m); u, if not NULL, receives W r + q. */
inline dls_certificate certify(const dls_contact &problem, const std::vector<double> &r,
                               std::vector<double> *u = nullptr) {
  dls_certificate certificate = {};
  const double *data =
      detail::pointer(r, detail::size(problem.d, problem.nc), "certify", "r", false);
  std::vector<double> position(r.size());
  call([&](dls_error *e) {
    return dls_contact_certify(&problem, data, position.data(), &certificate, e);
  });
  if (u) *u = std::move(position);
  return certificate;
}

/* The friction below which each load has one answer, and a least one with two: dls_contact_fold.
 * q, r, other, if given, receive the load and its answers. */
inline dls_fold fold(const dls_contact &problem, std::vector<double> *q = nullptr,
                     std::vector<double> *r = nullptr, std::vector<double> *other = nullptr) {
  dls_fold found = {};
  for (std::vector<double> *x : {q, r, other})
    if (x) x->assign(detail::size(problem.d, problem.nc), 0);
  call([&](dls_error *e) {
    return dls_contact_fold(&problem, &found, nullptr, q ? q->data() : nullptr,
                            r ? r->data() : nullptr, other ? other->data() : nullptr, e);
  });
  return found;
}

/* The state of each candidate of an answer. */
inline std::vector<dls_contact_state> states(const dls_contact &problem, const answer &a) {
  std::vector<dls_contact_state> state(static_cast<std::size_t>(problem.nc));
  const std::size_t m = detail::size(problem.d, problem.nc);
  const double *r = detail::pointer(a.r, m, "states", "r", false);
  const double *u = detail::pointer(a.u, m, "states", "u", false);
  call([&](dls_error *e) { return dls_contact_states(&problem, r, u, state.data(), e); });
  return state;
}

/* ---- solving --------------------------------------------------------------------------------- */

namespace detail {

/* Puts a function into limits for as long as it lives, and keeps what it throws. */
class watch {
public:
  watch(dls_limits *limits, const progress &f) : function(f) {
    if (!f) return;
    limits->progress = look;
    limits->progress_data = this;
  }
  watch(const watch &) = delete;
  watch &operator=(const watch &) = delete;
  void rethrow() const {
    if (thrown) std::rethrow_exception(thrown);
  }

private:
  static int look(void *data, const dls_progress *p) {
    watch *self = static_cast<watch *>(data);
    try {
      return self->function(*p);
    } catch (...) {
      self->thrown = std::current_exception();
      return 1;
    }
  }
  const progress &function;
  std::exception_ptr thrown;
};

inline answer blank(const dls_contact &problem, const std::vector<double> &start) {
  answer a = {};
  const std::size_t m = size(problem.d, problem.nc);
  if (start.empty())
    a.r.resize(m);
  else {
    (void)pointer(start, m, "solve", "start", false);
    a.r = start;
  }
  a.u.resize(m);
  return a;
}

} /* namespace detail */

/* Solves in one call. start: m for a warm start (limits.warm_start is set), empty for none. */
inline answer solve(const dls_contact &problem, settings s = settings(),
                    const std::vector<double> &start = {}, const progress &look = nullptr) {
  answer a = detail::blank(problem, start);
  if (!start.empty()) s.limits.warm_start = 1;
  const detail::watch w(&s.limits, look);
  a.status = call(
      [&](dls_error *e) { return dls_solve(&problem, &s, a.r.data(), a.u.data(), &a.info, e); });
  w.rethrow();
  return a;
}

/* A workspace for problems of dimension d with at most nc candidates, for many solves. */
class solver {
public:
  solver(int d, int nc, const settings &s = settings()) : dimension(d) {
    dls_solver *out = nullptr;
    call([&](dls_error *e) { return dls_solver_create(&out, d, nc, &s, e); });
    work.reset(out);
  }
  /* start: used where limits.warm_start is set */
  answer solve(const dls_contact &problem, const std::vector<double> &start = {}) {
    answer a = detail::blank(problem, start);
    a.status = call([&](dls_error *e) {
      return dls_solver_solve(work.get(), &problem, a.r.data(), a.u.data(), &a.info, e);
    });
    return a;
  }
  void set_limits(const dls_limits &limits) {
    call([&](dls_error *e) { return dls_solver_set_limits(work.get(), &limits, e); });
  }
  /* Returns the start of the next solve, whose contact c is from[c] of the last one (-1: new). */
  std::vector<double> map(const std::vector<int> &from) {
    std::vector<double> start(detail::size(dimension, static_cast<int>(from.size())));
    call([&](dls_error *e) {
      return dls_solver_map(work.get(), static_cast<int>(from.size()), from.data(), start.data(),
                            e);
    });
    return start;
  }
  const double *direction() const {
    return dls_solver_direction(work.get());
  }
  const double *farkas() const {
    return dls_solver_farkas(work.get());
  }
  dls_solver *get() const noexcept {
    return work.get();
  }

private:
  detail::held<dls_solver, dls_solver_destroy> work;
  int dimension;
};

/* ---- reduction ------------------------------------------------------------------------------- */

namespace detail {

/* Returns the contacts of a model that are active. */
inline std::size_t contacts(const dls_model &model) {
  const int all = model.P.p ? model.P.cols : model.nodes;
  std::size_t kept = 0;
  for (int c = 0; c < all; c++)
    kept += !model.active || model.active[c] != 0;
  return kept;
}

} /* namespace detail */

/* Solves the contact problem of a model in one call (dls_solve_model). An empty f or g stands for
 * 0, an empty mu for model.mu. */
inline answer solve_model(const dls_model &model, const std::vector<double> &f,
                          const std::vector<double> &g, const std::vector<double> &mu) {
  const std::size_t n = detail::size(model.n, 1), nc = detail::contacts(model);
  const double *F = detail::pointer(f, n, "solve_model", "f", true);
  const double *G =
      detail::pointer(g, detail::size(model.d, model.nodes), "solve_model", "g", true);
  const double *MU = detail::pointer(mu, nc, "solve_model", "mu", true);
  answer a = {};
  a.r.resize(static_cast<std::size_t>(model.d) * nc);
  a.u.resize(a.r.size());
  a.x.resize(n);
  a.status = call([&](dls_error *e) {
    return dls_solve_model(&model, F, G, MU, a.r.data(), a.u.data(), a.x.data(), &a.info, e);
  });
  return a;
}

/* Settings of a reduction, filled with the defaults. */
struct reduction_settings : dls_reduction_settings {
  reduction_settings() : dls_reduction_settings() {
    dls_reduction_settings_init(this);
  }
};

/* K -> r and x for many loads, on W or on K (settings.on). Sizes of vectors are checked; an empty f
 * or g stands for 0. contact and recover need W: settings.on = DLS_ON_W. */
class reduction {
public:
  explicit reduction(const dls_model &model, const reduction_settings &s = reduction_settings())
      : n(model.n), gaps(0) {
    dls_reduction *out = nullptr;
    call([&](dls_error *e) { return dls_reduction_create(&out, &model, &s, e); });
    work.reset(out);
    per = s.frictionless ? 1 : static_cast<std::size_t>(model.d);
    count(model);
  }
  /* new values on the pattern of the first model */
  void update(const dls_model &model) {
    call([&](dls_error *e) { return dls_reduction_update(work.get(), &model, e); });
  }
  /* new contacts on the same K: dls_reduction_move */
  void move(const dls_model &model, const std::vector<double> &g = {}) {
    const double *G = detail::pointer(g, detail::size(model.d, model.nodes), "move", "g", true);
    call([&](dls_error *e) { return dls_reduction_move(work.get(), &model, G, e); });
    count(model);
  }
  void load(const std::vector<double> &f, const std::vector<double> &g = {}) {
    const double *F = detail::pointer(f, unknowns(), "load", "f", true);
    const double *G = detail::pointer(g, gaps, "load", "g", true);
    call([&](dls_error *e) { return dls_reduction_load(work.get(), F, G, e); });
  }
  void load_free(const std::vector<double> &x_free, const std::vector<double> &g = {}) {
    const double *X = detail::pointer(x_free, unknowns(), "load_free", "x_free", false);
    const double *G = detail::pointer(g, gaps, "load_free", "g", true);
    call([&](dls_error *e) { return dls_reduction_load_free(work.get(), X, G, e); });
  }
  /* a view: mu and the reduction have to outlive it */
  dls_contact contact(const std::vector<double> &mu) const {
    const double *MU = detail::pointer(mu, candidates, "contact", "mu", true);
    dls_contact problem = {};
    call([&](dls_error *e) { return dls_reduction_contact(work.get(), MU, &problem, e); });
    return problem;
  }
  std::vector<double> recover(const std::vector<double> &r) {
    std::vector<double> x(unknowns());
    const double *R = detail::pointer(r, m, "recover", "r", false);
    call([&](dls_error *e) { return dls_reduction_recover(work.get(), R, x.data(), e); });
    return x;
  }
  /* solves, with the certificate of the body: dls_reduction_solve. x, if given, receives a copy of
   * answer.x */
  answer solve(const std::vector<double> &mu, std::vector<double> *x = nullptr,
               settings s = settings(), const std::vector<double> &start = {},
               const progress &look = nullptr) {
    const double *MU = detail::pointer(mu, candidates, "solve", "mu", true);
    dls_contact sizes = {}; /* on K there is no W */
    sizes.nc = static_cast<int>(candidates);
    sizes.d = candidates ? static_cast<int>(m / candidates) : 2;
    answer a = detail::blank(sizes, start);
    if (!start.empty()) s.limits.warm_start = 1;
    a.x.resize(unknowns());
    const detail::watch w(&s.limits, look);
    a.status = call([&](dls_error *e) {
      return dls_reduction_solve(work.get(), MU, &s, a.r.data(), a.u.data(), a.x.data(), &a.info,
                                 e);
    });
    w.rethrow();
    if (x) *x = a.x;
    return a;
  }
  /* how much is carried: loads f + lambda f1, gaps g: dls_limit_load. r, x, motion, if given, receive
   * the answer at `carried` and the motion at `refused` */
  dls_limit limit(const std::vector<double> &f1, const std::vector<double> &mu,
                  const std::vector<double> &f = {}, const std::vector<double> &g = {},
                  const dls_limit_settings *s = nullptr, std::vector<double> *r = nullptr,
                  std::vector<double> *x = nullptr, std::vector<double> *motion = nullptr) {
    const double *F1 = detail::pointer(f1, unknowns(), "limit", "f1", false);
    const double *MU = detail::pointer(mu, candidates, "limit", "mu", false);
    const double *F = detail::pointer(f, unknowns(), "limit", "f", true);
    const double *G = detail::pointer(g, gaps, "limit", "g", true);
    std::vector<double> R(m), X(unknowns()), B(unknowns());
    dls_limit found = {};
    call([&](dls_error *e) {
      return dls_limit_load(work.get(), F, F1, G, MU, nullptr, s, R.data(), X.data(), B.data(),
                            &found, e);
    });
    if (r) *r = std::move(R);
    if (x) *x = std::move(X);
    if (motion) *motion = std::move(B);
    return found;
  }
  /* the certificate of (x, r) on the body; u, if not NULL, receives H^T x + g */
  dls_certificate certify(const std::vector<double> &mu, const std::vector<double> &r,
                          const std::vector<double> &x, std::vector<double> *u = nullptr) {
    const double *MU = detail::pointer(mu, candidates, "certify", "mu", true);
    const double *R = detail::pointer(r, m, "certify", "r", false);
    const double *X = detail::pointer(x, unknowns(), "certify", "x", false);
    dls_certificate certificate = {};
    std::vector<double> position(m);
    call([&](dls_error *e) {
      return dls_reduction_certify(work.get(), MU, R, X, position.data(), &certificate, e);
    });
    if (u) *u = std::move(position);
    return certificate;
  }
  /* the state of each contact, on W or on K */
  std::vector<dls_contact_state> states(const std::vector<double> &mu, const answer &a) {
    const double *MU = detail::pointer(mu, candidates, "states", "mu", true);
    const double *R = detail::pointer(a.r, m, "states", "r", false);
    const double *U = detail::pointer(a.u, m, "states", "u", false);
    std::vector<dls_contact_state> state(candidates);
    call([&](dls_error *e) { return dls_reduction_states(work.get(), MU, R, U, state.data(), e); });
    return state;
  }
  /* the rigid motion that proves that nothing holds a body, after DLS_NO_SOLUTION; or empty */
  std::vector<double> motion() const {
    const double *b = dls_reduction_motion(work.get(), nullptr);
    return b ? std::vector<double>(b, b + unknowns()) : std::vector<double>();
  }
  std::vector<double> nodal(const std::vector<double> &r) const {
    std::vector<double> R(gaps);
    const double *weights = detail::pointer(r, m, "nodal", "r", false);
    call([&](dls_error *e) { return dls_reduction_nodal(work.get(), weights, R.data(), e); });
    return R;
  }
  dls_reduction_info info() const {
    dls_reduction_info i = {};
    call([&](dls_error *e) { return dls_reduction_get_info(work.get(), &i, e); });
    return i;
  }
  dls_reduction *get() const noexcept {
    return work.get();
  }

private:
  void count(const dls_model &model) {
    gaps = detail::size(model.d, model.nodes);
    candidates = detail::contacts(model);
    m = per * candidates;
  }
  std::size_t unknowns() const {
    return static_cast<std::size_t>(n);
  }
  int n;
  std::size_t gaps, candidates = 0, m = 0, per = 0;
  detail::held<dls_reduction, dls_reduction_destroy> work;
};

/* ---- H from meshes --------------------------------------------------------------------------- */

/* What dls_pairs_find finds, freed with the object; pointers are valid as long as it lives. */
class pairs {
public:
  explicit pairs(const dls_surfaces &surfaces) : held() {
    call([&](dls_error *e) { return dls_pairs_find(&surfaces, &held, e); });
    space = static_cast<std::size_t>(surfaces.d);
  }
  pairs(const pairs &) = delete;
  pairs &operator=(const pairs &) = delete;
  ~pairs() {
    dls_pairs_free(&held);
  }
  /* sets nodes, HN, HT and P of a model */
  void into(dls_model *model) const {
    model->nodes = held.nodes;
    model->HN = held.HN;
    model->HT = held.HT;
    model->P = held.P;
  }
  std::vector<double> g() const {
    return {held.g, held.g + space * static_cast<std::size_t>(held.nodes)};
  }
  const dls_pairs &get() const noexcept {
    return held;
  }

private:
  dls_pairs held;
  std::size_t space = 0;
};

/* ---- motion ---------------------------------------------------------------------------------- */

/* Settings of a motion, filled with the defaults; h has to be set. */
struct motion_settings : dls_motion_settings {
  motion_settings() : dls_motion_settings() {
    dls_motion_settings_init(this);
  }
};

/* Bodies that move; the arrays of the model have to outlive it. */
class motion {
public:
  motion(const dls_motion_model &model, const motion_settings &s)
      : n(static_cast<std::size_t>(model.n)), local(detail::size(model.d, model.nodes)),
        candidates(static_cast<std::size_t>(model.P.p ? model.P.cols : model.nodes)) {
    dls_motion *out = nullptr;
    call([&](dls_error *e) { return dls_motion_create(&out, &model, &s, e); });
    work.reset(out);
  }
  void start(const std::vector<double> &x, const std::vector<double> &v, double t) {
    const double *X = detail::pointer(x, n, "start", "x", true);
    const double *V = detail::pointer(v, n, "start", "v", true);
    call([&](dls_error *e) { return dls_motion_start(work.get(), X, V, t, e); });
  }
  /* a status above 0: not certified, the state is that of the step before */
  dls_status step(const std::vector<double> &f, const std::vector<double> &y = {},
                  const std::vector<double> &mu = {}, dls_info *info = nullptr) {
    const double *F = detail::pointer(f, n, "step", "f", true);
    const double *Y = detail::pointer(y, local, "step", "y", true);
    const double *MU = detail::pointer(mu, candidates, "step", "mu", true);
    return call([&](dls_error *e) { return dls_motion_step(work.get(), F, Y, MU, info, e); });
  }
  void set_h(double h) {
    call([&](dls_error *e) { return dls_motion_set_h(work.get(), h, e); });
  }
  /* a view of arrays that change with each step */
  dls_motion_state state() const {
    dls_motion_state s = {};
    call([&](dls_error *e) { return dls_motion_get_state(work.get(), &s, e); });
    return s;
  }
  dls_motion_energies energies() const {
    dls_motion_energies s = {};
    call([&](dls_error *e) { return dls_motion_get_energies(work.get(), &s, e); });
    return s;
  }
  dls_motion *get() const noexcept {
    return work.get();
  }

private:
  std::size_t n, local, candidates;
  detail::held<dls_motion, dls_motion_destroy> work;
};

} /* namespace delassus */

#endif
