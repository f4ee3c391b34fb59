! point.f90: the program of README.md in Fortran: a point on springs is pushed onto the floor y = 0
! and slides to the right.
!
! Output:
!   solved: r_n =  10.9375, r_t =  -2.1875, x =   0.9375
program point
  use delassus
  implicit none
  real(c_double), target :: K(2, 2) = reshape([3, 1, 1, 2], [2, 2]), one(1) = [1d0]
  integer(c_int), target :: p(2) = [0, 1], along(1) = [0], up(1) = [1]  ! H_N picks y, H_T picks x
  real(c_double) :: r(2), x(2)
  type(dls_model) :: model
  type(dls_error) :: error
  integer(c_int) :: status

  model%d = 2
  model%n = 2
  model%nodes = 1
  model%operator_kind = DLS_STIFFNESS_DENSE
  model%factorization = DLS_CHOLESKY
  model%K = dls_dense_of(K)
  model%HN = dls_sparse_of(2, p, up, one)
  model%HT = dls_sparse_of(2, p, along, one)
  status = dls_solve_model(model, f=[5d0, -10d0], mu=[0.2d0], r=r, x=x, error=error)
  if (status < 0) then
    print '(a)', dls_message(error)
    stop 1
  end if
  print '(a, 3(a, f8.4))', dls_text(dls_status_text(status)), ': r_n = ', r(1), &
    ', r_t = ', r(2), ', x = ', x(1)
end program
