! door.f90: prints the lines that test_door.c compares, by the module delassus.
program door
  use, intrinsic :: iso_fortran_env, only: int64
  use delassus
  implicit none
  real(c_double), target :: K(2, 2) = reshape([3, 1, 1, 2], [2, 2]), one(1) = [1d0]
  real(c_double), target :: spring(2, 2) = reshape([5, -5, -5, 5], [2, 2])
  integer(c_int), target :: p(2) = [0, 1], none(2) = [0, 0], first(1) = [0], second(1) = [1]
  real(c_double) :: r(2), u(2), x(2)
  type(dls_model) :: held, loose
  type(dls_reduction_settings) :: settings
  type(dls_info) :: info
  type(c_ptr) :: reduction
  integer(c_int) :: status

  held = body(dls_dense_of(K), second, first, p)
  loose = body(dls_dense_of(spring), first, first, none)
  status = dls_solve_model(held, f=[5d0, -10d0], mu=[0.2d0], r=r, u=u, x=x, info=info)
  call put('held', info%certificate)
  call dls_reduction_settings_init(settings)
  settings%on = DLS_ON_K
  status = dls_reduction_create(reduction, held, settings)
  if (status == 0) status = dls_reduction_load(reduction, [5d0, -10d0])
  if (status == 0) status = dls_reduction_solve(reduction, [0.2d0], r=r, u=u, x=x, info=info)
  if (dls_reduction_certify(reduction, [0.2d0], r, x, u, info%certificate) /= 0) stop 1
  call put('on-K', info%certificate)
  call dls_reduction_destroy(reduction)
  status = dls_solve_model(loose, [0d0, -10d0], [1d0, 0d0], [0d0], r, u, x, info)
  call put('pressed', info%certificate)
  settings%on = DLS_ON_W
  status = dls_reduction_create(reduction, loose, settings)
  print '(a, i0)', 'on-W ', status
  status = dls_solve_model(loose, [0d0, 10d0], [1d0, 0d0], [0d0], r, u, x, info)
  call put('flies', info%certificate)

contains

  function body(stiffness, normal, tangent, pT) result(model)
    type(dls_dense), intent(in) :: stiffness
    integer(c_int), intent(in), target :: normal(1), tangent(1), pT(2)
    type(dls_model) :: model
    model%d = 2
    model%n = 2
    model%nodes = 1
    model%operator_kind = DLS_STIFFNESS_DENSE
    model%factorization = DLS_CHOLESKY
    model%K = stiffness
    model%HN = dls_sparse_of(2, p, normal, one)
    model%HT = dls_sparse_of(2, pT, tangent, one)
  end function

  subroutine put(name, c)
    character(*), intent(in) :: name
    type(dls_certificate), intent(in) :: c
    print '(a, 1x, i0, 8(1x, z16.16))', name, status, &
      transfer([r, u, x, c%residual, c%equilibrium], [0_int64])
  end subroutine

end program
