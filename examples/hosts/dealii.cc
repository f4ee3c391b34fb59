/*
 * dealii.cc: deal.II as the host. A block of bilinear elements (plane strain), held at its top, is
 * pressed on a smooth floor by a body force that grows to the right, and part of it lifts off. The
 * SparseMatrix and the load of deal.II go to delassus, beside it a primal-dual active set method
 * with deal.II's own factorisation (UMFPACK), as in its step-41.
 *
 * Output:
 *   1122 unknowns, 33 contact nodes, solved: 25 touch
 *   x agrees with the active set method to 1e-8: yes
 */
#include <deal.II/base/quadrature_lib.h>
#include <deal.II/dofs/dof_handler.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/fe/fe_system.h>
#include <deal.II/fe/fe_values.h>
#include <deal.II/fe/mapping_q1.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/grid/tria.h>
#include <deal.II/lac/sparse_direct.h>
#include <deal.II/numerics/matrix_tools.h>

#include <cstdio>
#include <delassus.hpp>

using namespace dealii;
using delassus::solve_model;

/* K and f of the block without supports. */
static void assemble(const DoFHandler<2> &dofs, SparseMatrix<double> &K, Vector<double> &f) {
  const QGauss<2> points(2);
  FEValues<2> fe(dofs.get_fe(), points,
                 update_values | update_gradients | update_quadrature_points | update_JxW_values);
  const unsigned m = dofs.get_fe().n_dofs_per_cell();
  std::vector<types::global_dof_index> at(m);
  const FEValuesExtractors::Vector u(0);
  for (const auto &cell : dofs.active_cell_iterators()) {
    fe.reinit(cell);
    FullMatrix<double> k(m, m);
    Vector<double> load(m);
    for (unsigned q = 0; q < points.size(); q++)
      for (unsigned i = 0; i < m; i++) {
        const auto e = fe[u].symmetric_gradient(i, q);
        for (unsigned j = 0; j < m; j++)
          k(i, j) += (2 * (e * fe[u].symmetric_gradient(j, q)) +
                      fe[u].divergence(i, q) * fe[u].divergence(j, q)) * fe.JxW(q);
        load(i) += fe[u].value(i, q)[1] * (1 - 3 * fe.quadrature_point(q)[0]) * fe.JxW(q);
      }
    cell->get_dof_indices(at);
    K.add(at, k);
    f.add(at, load);
  }
}

/* Holds the unknowns of `fixed` at their values. */
static void hold(const std::map<types::global_dof_index, double> &fixed, SparseMatrix<double> &K,
                 Vector<double> &f) {
  Vector<double> x(f.size());
  MatrixTools::apply_boundary_values(fixed, K, x, f);
}

int main() {
  Triangulation<2> mesh;
  GridGenerator::subdivided_hyper_rectangle(mesh, {32, 16}, Point<2>(), Point<2>(2, 1));
  const FESystem<2> element(FE_Q<2>(1), 2);
  DoFHandler<2> dofs(mesh);
  dofs.distribute_dofs(element);
  const unsigned n = dofs.n_dofs();
  std::vector<Point<2>> X(n);
  DoFTools::map_dofs_to_support_points(MappingQ1<2>(), dofs, X);
  std::map<types::global_dof_index, double> fixed;
  std::vector<unsigned> low; /* the unknowns y of the floor's nodes */
  const ComponentMask y = element.component_mask(FEValuesExtractors::Scalar(1));
  const IndexSet vertical = DoFTools::extract_dofs(dofs, y);
  for (unsigned i = 0; i < n; i++) {
    if (X[i][1] > 1 - 1e-9) fixed[i] = 0;
    if (X[i][1] < 1e-9 && vertical.is_element(i)) low.push_back(i);
  }
  DynamicSparsityPattern pattern(n);
  DoFTools::make_sparsity_pattern(dofs, pattern);
  SparsityPattern sparsity;
  sparsity.copy_from(pattern);
  SparseMatrix<double> K0(sparsity), K(sparsity);
  Vector<double> f0(n), f(n);
  assemble(dofs, K0, f0);
  K.copy_from(K0), f = f0;
  hold(fixed, K, f);
  const unsigned nc = low.size();
  const std::vector<double> mu(nc);
  /* -> delassus */
  delassus::entries k(n), N(n), T(n);
  for (const auto &e : K) k.add(e.row(), e.column(), e.value());
  for (unsigned c = 0; c < nc; c++) N.add(low[c], c, 1);
  const delassus::sparse Ks = k.columns(n), HN = N.columns(nc), HT = T.columns(nc);
  const auto a = solve_model(delassus::model(2, Ks, HN, HT), {f.begin(), f.end()}, {}, mu);
  /* <- delassus */
  unsigned touching = 0;
  for (unsigned c = 0; c < nc; c++) touching += a.r[2 * c] > 0;
  /* the active set method: holds the nodes that press, until the set stays */
  Vector<double> x(n), rest(n);
  std::vector<bool> active(nc, true), before;
  for (int turn = 0; turn < 50 && active != before; turn++) {
    auto held = fixed;
    for (unsigned c = 0; c < nc; c++)
      if (active[c]) held[low[c]] = 0;
    SparseMatrix<double> A(sparsity);
    A.copy_from(K0), f = f0;
    hold(held, A, f);
    SparseDirectUMFPACK factor;
    factor.initialize(A);
    factor.vmult(x, f);
    K0.residual(rest, x, f0); /* f0 - K0 x = -r at the floor */
    before = active;
    for (unsigned c = 0; c < nc; c++) active[c] = active[c] ? rest[low[c]] < 0 : x[low[c]] < 0;
  }
  double apart = 0;
  for (unsigned i = 0; i < n; i++) apart = std::max(apart, std::fabs(x[i] - a.x[i]));
  std::printf("%u unknowns, %u contact nodes, %s: %u touch\n", n, nc, a.text(), touching);
  std::printf("x agrees with the active set method to 1e-8: %s\n",
              apart <= 1e-8 * x.linfty_norm() ? "yes" : "no");
  std::fprintf(stderr, "apart %.0e\n", apart / x.linfty_norm());
  return !a.solved();
}
