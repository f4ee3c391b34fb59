/*
 * delassus.hpp: the library for C++17: objects that free themselves, std::vector in and out, errors
 * as exceptions. Header only; everything is that of delassus.h, which says what it means.
 *
 *   delassus::reduction reduction(model);              K, H_N, H_T -> W
 *   reduction.load(f);                                 q
 *   auto answer = delassus::solve(reduction.contact(mu));
 *   auto x = reduction.recover(answer.r);
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
  dls_info info;
  bool solved() const noexcept {
    return status == DLS_OK || status == DLS_TO_ROUNDING;
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
};

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

/* Settings of a reduction, filled with the defaults. */
struct reduction_settings : dls_reduction_settings {
  reduction_settings() : dls_reduction_settings() {
    dls_reduction_settings_init(this);
  }
};

/* K -> W, q and back. Sizes of vectors are checked; an empty f or g stands for 0. */
class reduction {
public:
  explicit reduction(const dls_model &model, const reduction_settings &s = reduction_settings())
      : n(model.n), gaps(0) {
    dls_reduction *out = nullptr;
    call([&](dls_error *e) { return dls_reduction_create_with(&out, &model, &s, e); });
    work.reset(out);
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
  /* solves, with the certificate of the body: dls_reduction_solve. x receives the unknowns */
  answer solve(const std::vector<double> &mu, std::vector<double> *x, settings s = settings(),
               const std::vector<double> &start = {}, const progress &look = nullptr) {
    const double *MU = detail::pointer(mu, candidates, "solve", "mu", true);
    dls_contact sizes = {}; /* on K there is no W */
    sizes.nc = static_cast<int>(candidates);
    sizes.d = candidates ? static_cast<int>(m / candidates) : 2;
    answer a = detail::blank(sizes, start);
    if (!start.empty()) s.limits.warm_start = 1;
    std::vector<double> unknown(unknowns());
    const detail::watch w(&s.limits, look);
    a.status = call([&](dls_error *e) {
      return dls_reduction_solve(work.get(), MU, &s, a.r.data(), a.u.data(), unknown.data(),
                                 &a.info, e);
    });
    w.rethrow();
    if (x) *x = std::move(unknown);
    return a;
  }
  std::vector<double> nodal(const std::vector<double> &r) const {
    std::vector<double> R(gaps);
    const double *weights = detail::pointer(r, m, "nodal", "r", false);
    call([&](dls_error *e) { return dls_reduction_nodal(work.get(), weights, R.data(), e); });
    return R;
  }
  double balance(const std::vector<double> &r) {
    double imbalance = 0;
    const double *R = detail::pointer(r, m, "balance", "r", false);
    call([&](dls_error *e) { return dls_reduction_balance(work.get(), R, &imbalance, e); });
    return imbalance;
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
    candidates = static_cast<std::size_t>(model.P.p ? model.P.cols : model.nodes);
    if (model.active) {
      std::size_t kept = 0;
      for (std::size_t c = 0; c < candidates; c++)
        kept += model.active[c] != 0;
      candidates = kept;
    }
    m = static_cast<std::size_t>(model.d) * candidates;
  }
  std::size_t unknowns() const {
    return static_cast<std::size_t>(n);
  }
  int n;
  std::size_t gaps, candidates = 0, m = 0;
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
