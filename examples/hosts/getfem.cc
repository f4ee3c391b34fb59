/*
 * getfem.cc: GetFEM as the host. A block of trilinear elements, held at its top and sheared, stands
 * on a rough floor. K, the traces B_N, B_T and the load go to delassus, beside it to GetFEM's
 * own contact brick (augmented Lagrangian, its parameter r tuned by hand).
 *
 * GetFEM writes B_N U <= gap and multipliers <= 0: H_N = -B_N^T, r_n = -lambda_N, H_T = B_T^T.
 *
 * Output:
 *   2187 unknowns, 81 contact nodes: free 26, slip 31, stick 24
 *   x and r_n agree with GetFEM's brick to 1e-8: yes
 */
#include <getfem/getfem_assembling.h>
#include <getfem/getfem_contact_and_friction_nodal.h>
#include <getfem/getfem_model_solvers.h>
#include <getfem/getfem_regular_meshes.h>

#include <cstdio>
#include <ctime>
#include <delassus.hpp>

typedef gmm::csc_matrix<double> columns;
static dls_sparse view(const columns &A) {
  return {int(A.nr), int(A.nc), reinterpret_cast<const int *>(&A.jc[0]),
          reinterpret_cast<const int *>(&A.ir[0]), &A.pr[0]};
}

static double seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

static double distance(const std::vector<double> &a, const std::vector<double> &b) {
  double apart = 0, size = 0;
  for (size_t k = 0; k < a.size(); k++) /* max |a - b| over max |b| */
    apart = std::max(apart, std::fabs(a[k] - b[k])), size = std::max(size, std::fabs(b[k]));
  return apart / size;
}

int main() {
  const double friction = 0.3;
  getfem::mesh mesh;
  getfem::regular_unit_mesh(mesh, std::vector<size_t>(3, 8), bgeot::parallelepiped_geotrans(3, 1));
  getfem::mesh_fem mf(mesh, 3), scalar(mesh);
  getfem::mesh_im mim(mesh);
  mf.set_finite_element(getfem::fem_descriptor("FEM_QK(3,1)"));
  scalar.set_finite_element(getfem::fem_descriptor("FEM_QK(3,1)"));
  mim.set_integration_method(getfem::int_method_descriptor("IM_GAUSS_PARALLELEPIPED(3,4)"));
  const size_t n = mf.nb_dof();
  gmm::row_matrix<gmm::rsvector<double>> K(n, n);
  std::vector<double> f(n), L(scalar.nb_dof(), 1), M(scalar.nb_dof(), 1);
  getfem::asm_stiffness_matrix_for_linear_elasticity(K, mim, mf, scalar, L, M);
  /* holds the top, loads the nodes half way up, lists the nodes at the bottom */
  std::vector<size_t> bottom;
  std::vector<bool> held(n);
  for (size_t i = 0; i < n; i += 3) {
    const bgeot::base_node p = mf.point_of_basic_dof(i);
    if (p[2] < 1e-9) bottom.push_back(i);
    for (int k = 0; k < 3; k++) held[i + k] = p[2] > 1 - 1e-9;
    if (std::fabs(p[2] - 0.5) < 1e-9) f[i] = 4e-4, f[i + 1] = 1e-4, f[i + 2] = 1e-3 - 5e-3 * p[0];
  }
  for (size_t i = 0; i < n; i++) {
    const gmm::rsvector<double> row = K.row(i);
    for (auto e = row.begin(); e != row.end(); ++e)
      if (held[i] || held[e->c]) K(i, e->c) = i == e->c ? 1 : 0;
  }
  const size_t nc = bottom.size();
  getfem::CONTACT_B_MATRIX BN(nc, n), BT(2 * nc, n);
  gmm::row_matrix<gmm::rsvector<double>> HN(n, nc), HT(n, 2 * nc);
  for (size_t c = 0; c < nc; c++) {
    BN(c, bottom[c] + 2) = -1;
    HN(bottom[c] + 2, c) = 1;
    for (int k = 0; k < 2; k++) BT(2 * c + k, bottom[c] + k) = HT(bottom[c] + k, 2 * c + k) = 1;
  }
  /* delassus */
  double start = seconds();
  columns Kc, N, T;
  Kc.init_with(K), N.init_with(HN), T.init_with(HT);
  const std::vector<double> mu(nc, friction);
  dls_model model = {};
  model.d = 3, model.n = int(n), model.nodes = int(nc);
  model.operator_kind = DLS_STIFFNESS_SPARSE, model.factorization = DLS_CHOLESKY;
  model.Ks = view(Kc), model.HN = view(N), model.HT = view(T);
  delassus::settings settings;
  settings.limits.tol = 1e-12;
  delassus::reduction reduction(model);
  reduction.load(f);
  const delassus::answer a = reduction.solve(mu, nullptr, settings);
  if (!a.solved()) return std::printf("delassus: %s\n", a.text()), 1;
  const double ours = seconds() - start;
  int count[3] = {};
  for (dls_contact_state s : reduction.states(mu, a)) count[s]++;
  /* GetFEM's brick */
  start = seconds();
  getfem::model md;
  md.add_fem_variable("u", mf);
  getfem::add_explicit_matrix(md, "u", "u", K, true, true);
  getfem::add_explicit_rhs(md, "u", f);
  md.add_fixed_size_variable("normal", nc);
  md.add_fixed_size_variable("tangent", 2 * nc);
  md.add_initialized_scalar_data("r", 0.1);
  md.add_initialized_scalar_data("friction", friction);
  getfem::add_basic_contact_brick(md, "u", "normal", "tangent", "r", BN, BT, "friction");
  gmm::iteration iteration(1e-13, 0, 200);
  getfem::standard_solve(md, iteration);
  const double theirs = seconds() - start;
  std::vector<double> rn(nc);
  for (size_t c = 0; c < nc; c++) rn[c] = -a.r[3 * c];
  const std::vector<double> &theirs_n = md.real_variable("normal");
  const double apart = std::max(distance(md.real_variable("u"), a.x), distance(theirs_n, rn));
  std::printf("%zu unknowns, %zu contact nodes: ", n, nc);
  std::printf("free %d, slip %d, stick %d\n", count[0], count[1], count[2]);
  std::printf("x and r_n agree with GetFEM's brick to 1e-8: %s\n", apart <= 1e-8 ? "yes" : "no");
  std::fprintf(stderr, "apart %.0e; CPU: brick %.2f s, delassus %.2f s\n", apart, theirs, ours);
  return !(apart <= 1e-8);
}
