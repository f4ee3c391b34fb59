! delassus.f90: the library for Fortran 2018: its types and constants as it was compiled with, its
! functions under their own names, and four helpers. include/delassus/*.h are the manual.
!
!   type(dls_contact) :: problem;  type(dls_error) :: error
!   real(c_double), target :: W(m, m), q(m), mu(nc);  real(c_double) :: r(m)
!   problem%d = 2;  problem%nc = nc;  problem%W = dls_dense_of(W)
!   problem%q = c_loc(q);  problem%mu = c_loc(mu)
!   status = dls_solve(problem, r=r, error=error)
!   if (status < 0) print *, dls_message(error)
!
! An argument that may be NULL in C is optional here. Indices in arrays of the library (dls_sparse,
! active_list, error%index) count from 0. Arrays behind c_loc have the attribute target and live as
! long as the view is used.
module delassus
  use, intrinsic :: iso_c_binding
  implicit none
  private
  public :: dls_dense_of, dls_sparse_of, dls_message, dls_text

!TYPES

  abstract interface
    ! for dls_limits%progress = c_funloc(..): other than 0 cancels
    function dls_progress_fn(data, progress) bind(c)
      import :: c_ptr, c_int, dls_progress
      type(c_ptr), value :: data
      type(dls_progress), intent(in) :: progress
      integer(c_int) :: dls_progress_fn
    end function
    ! for dls_model%solve = c_funloc(..): X := K^-1 X; other than 0 is a failure
    function dls_solve_fn(user, X, n, nrhs) bind(c)
      import :: c_ptr, c_int, c_double
      type(c_ptr), value :: user
      integer(c_int), value :: n, nrhs
      real(c_double), intent(inout) :: X(n, nrhs)
      integer(c_int) :: dls_solve_fn
    end function
  end interface
  public :: dls_progress_fn, dls_solve_fn

  interface
    ! ---- status.h, for dls_text ----
    function dls_version() bind(c) result(text)
      import :: c_ptr
      type(c_ptr) :: text
    end function
    function dls_status_name(status) bind(c) result(text)
      import :: c_ptr, c_int
      integer(c_int), value :: status
      type(c_ptr) :: text
    end function
    function dls_status_text(status) bind(c) result(text)
      import :: c_ptr, c_int
      integer(c_int), value :: status
      type(c_ptr) :: text
    end function
    function dls_solved(status) bind(c) result(solved)
      import :: c_int
      integer(c_int), value :: status
      integer(c_int) :: solved  ! 1 or 0
    end function

    ! ---- contact.h ----
    function dls_contact_check(problem, error) bind(c) result(status)
      import :: c_int, dls_contact, dls_error
      type(dls_contact), intent(in) :: problem
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_contact_certify(problem, r, u, certificate, error) bind(c) result(status)
      import :: c_int, c_double, dls_contact, dls_certificate, dls_error
      type(dls_contact), intent(in) :: problem
      real(c_double), intent(in) :: r(*)
      real(c_double), intent(inout), optional :: u(*)
      type(dls_certificate), intent(inout) :: certificate
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_contact_fold(problem, fold, state, q, r, other, error) bind(c) result(status)
      import :: c_int, c_double, dls_contact, dls_fold, dls_error
      type(dls_contact), intent(in) :: problem
      type(dls_fold), intent(inout) :: fold
      integer(c_int), intent(inout), optional :: state(*)
      real(c_double), intent(inout), optional :: q(*), r(*), other(*)
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_certificate_holds(certificate, tol) bind(c) result(holds)
      import :: c_int, c_double, dls_certificate
      type(dls_certificate), intent(in) :: certificate
      real(c_double), value :: tol
      integer(c_int) :: holds
    end function
    function dls_contact_states(problem, r, u, state, error) bind(c) result(status)
      import :: c_int, c_double, dls_contact, dls_error
      type(dls_contact), intent(in) :: problem
      real(c_double), intent(in) :: r(*), u(*)
      integer(c_int), intent(inout) :: state(*)
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function

    ! ---- solve.h ----
    subroutine dls_solver_settings_init(settings) bind(c)
      import :: dls_solver_settings
      type(dls_solver_settings), intent(inout) :: settings
    end subroutine
    function dls_method_find(name, method) bind(c) result(found)
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: name(*)  ! 'nlgs' // c_null_char
      integer(c_int), intent(inout) :: method
      integer(c_int) :: found
    end function
    function dls_solve(problem, settings, r, u, info, error) bind(c) result(status)
      import :: c_int, c_double, dls_contact, dls_solver_settings, dls_info, dls_error
      type(dls_contact), intent(in) :: problem
      type(dls_solver_settings), intent(in), optional :: settings
      real(c_double), intent(inout) :: r(*)
      real(c_double), intent(inout), optional :: u(*)
      type(dls_info), intent(inout), optional :: info
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_solve_model(model, f, g, mu, r, u, x, info, error) bind(c) result(status)
      import :: c_int, c_double, dls_model, dls_info, dls_error
      type(dls_model), intent(in) :: model
      real(c_double), intent(in), optional :: f(*), g(*), mu(*)
      real(c_double), intent(inout) :: r(*), x(*)
      real(c_double), intent(inout), optional :: u(*)
      type(dls_info), intent(inout), optional :: info
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_solver_create(solver, d, nc, settings, error) bind(c) result(status)
      import :: c_int, c_ptr, dls_solver_settings, dls_error
      type(c_ptr), intent(out) :: solver
      integer(c_int), value :: d, nc
      type(dls_solver_settings), intent(in), optional :: settings
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_solver_set_limits(solver, limits, error) bind(c) result(status)
      import :: c_int, c_ptr, dls_limits, dls_error
      type(c_ptr), value :: solver
      type(dls_limits), intent(in) :: limits
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_solver_map(solver, nc, from, r, error) bind(c) result(status)
      import :: c_int, c_ptr, c_double, dls_error
      type(c_ptr), value :: solver
      integer(c_int), value :: nc
      integer(c_int), intent(in) :: from(*) ! from 0 on, -1: a new contact
      real(c_double), intent(inout) :: r(*)
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_solver_solve(solver, problem, r, u, info, error) bind(c) result(status)
      import :: c_int, c_ptr, c_double, dls_contact, dls_info, dls_error
      type(c_ptr), value :: solver
      type(dls_contact), intent(in) :: problem
      real(c_double), intent(inout) :: r(*)
      real(c_double), intent(inout), optional :: u(*)
      type(dls_info), intent(inout), optional :: info
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    subroutine dls_solver_destroy(solver) bind(c)
      import :: c_ptr
      type(c_ptr), value :: solver
    end subroutine

    ! ---- reduction.h ----
    subroutine dls_reduction_settings_init(settings) bind(c)
      import :: dls_reduction_settings
      type(dls_reduction_settings), intent(inout) :: settings
    end subroutine
    function dls_reduction_create(reduction, model, settings, error) bind(c) result(status)
      import :: c_int, c_ptr, dls_model, dls_reduction_settings, dls_error
      type(c_ptr), intent(out) :: reduction
      type(dls_model), intent(in) :: model
      type(dls_reduction_settings), intent(in), optional :: settings
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_reduction_update(reduction, model, error) bind(c) result(status)
      import :: c_int, c_ptr, dls_model, dls_error
      type(c_ptr), value :: reduction
      type(dls_model), intent(in) :: model
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_reduction_get_info(reduction, info, error) bind(c) result(status)
      import :: c_int, c_ptr, dls_reduction_info, dls_error
      type(c_ptr), value :: reduction
      type(dls_reduction_info), intent(inout) :: info
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_reduction_load(reduction, f, g, error) bind(c) result(status)
      import :: c_int, c_ptr, c_double, dls_error
      type(c_ptr), value :: reduction
      real(c_double), intent(in), optional :: f(*), g(*)
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_reduction_load_free(reduction, x_free, g, error) bind(c) result(status)
      import :: c_int, c_ptr, c_double, dls_error
      type(c_ptr), value :: reduction
      real(c_double), intent(in) :: x_free(*)
      real(c_double), intent(in), optional :: g(*)
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_reduction_contact(reduction, mu, problem, error) bind(c) result(status)
      import :: c_int, c_ptr, dls_contact, dls_error
      type(c_ptr), value :: reduction
      type(c_ptr), value :: mu  ! c_loc: problem keeps it; c_null_ptr: that of the model
      type(dls_contact), intent(inout) :: problem
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_reduction_recover(reduction, r, x, error) bind(c) result(status)
      import :: c_int, c_ptr, c_double, dls_error
      type(c_ptr), value :: reduction
      real(c_double), intent(in) :: r(*)
      real(c_double), intent(inout) :: x(*)
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_reduction_certify(reduction, mu, r, x, u, certificate, error) bind(c) result(status)
      import :: c_int, c_ptr, c_double, dls_certificate, dls_error
      type(c_ptr), value :: reduction
      real(c_double), intent(in), optional :: mu(*)
      real(c_double), intent(in) :: r(*), x(*)
      real(c_double), intent(inout), optional :: u(*)
      type(dls_certificate), intent(inout) :: certificate
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_reduction_solve(reduction, mu, settings, r, u, x, info, error) bind(c) result(status)
      import :: c_int, c_ptr, c_double, dls_solver_settings, dls_info, dls_error
      type(c_ptr), value :: reduction
      real(c_double), intent(in), optional :: mu(*)
      type(dls_solver_settings), intent(in), optional :: settings
      real(c_double), intent(inout) :: r(*), x(*)
      real(c_double), intent(inout), optional :: u(*)
      type(dls_info), intent(inout), optional :: info
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    subroutine dls_limit_settings_init(settings) bind(c)
      import :: dls_limit_settings
      type(dls_limit_settings), intent(inout) :: settings
    end subroutine
    function dls_limit_load(reduction, f0, f1, g, mu, mu1, settings, r, x, motion, limit, error) &
        bind(c) result(status)
      import :: c_int, c_ptr, c_double, dls_limit_settings, dls_limit, dls_error
      type(c_ptr), value :: reduction
      real(c_double), intent(in), optional :: f0(*), f1(*), g(*), mu1(*)
      real(c_double), intent(in) :: mu(*)
      type(dls_limit_settings), intent(in), optional :: settings
      real(c_double), intent(inout) :: r(*)
      real(c_double), intent(inout), optional :: x(*), motion(*)
      type(dls_limit), intent(inout) :: limit
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_reduction_states(reduction, mu, r, u, state, error) bind(c) result(status)
      import :: c_int, c_ptr, c_double, dls_error
      type(c_ptr), value :: reduction
      real(c_double), intent(in), optional :: mu(*)
      real(c_double), intent(in) :: r(*), u(*)
      integer(c_int), intent(inout) :: state(*)
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_reduction_motion(reduction, unknown) bind(c) result(motion)
      import :: c_int, c_ptr
      type(c_ptr), value :: reduction
      integer(c_int), intent(inout), optional :: unknown
      type(c_ptr) :: motion  ! n, or c_null_ptr
    end function
    function dls_certificate_verdict(certificate, tol) bind(c) result(status)
      import :: c_int, c_double, dls_certificate
      type(dls_certificate), intent(in) :: certificate
      real(c_double), value :: tol
      integer(c_int) :: status
    end function
    function dls_reduction_nodal(reduction, r, nodal, error) bind(c) result(status)
      import :: c_int, c_ptr, c_double, dls_error
      type(c_ptr), value :: reduction
      real(c_double), intent(in) :: r(*)
      real(c_double), intent(inout) :: nodal(*)
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    subroutine dls_reduction_destroy(reduction) bind(c)
      import :: c_ptr
      type(c_ptr), value :: reduction
    end subroutine
    function dls_weighting_line(nodes, s, candidate, p, i, x, length, columns, error) bind(c) &
        result(status)
      import :: c_int, c_double, dls_error
      integer(c_int), value :: nodes
      real(c_double), intent(in) :: s(*)
      integer(c_int), intent(in), optional :: candidate(*)
      integer(c_int), intent(inout) :: p(*), i(*)
      real(c_double), intent(inout) :: x(*)
      real(c_double), intent(inout), optional :: length(*)
      integer(c_int), intent(inout) :: columns
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_weighting_quadratic(nodes, s, candidate, p, i, x, length, columns, error) &
        bind(c) result(status)
      import :: c_int, c_double, dls_error
      integer(c_int), value :: nodes
      real(c_double), intent(in) :: s(*)
      integer(c_int), intent(in), optional :: candidate(*)
      integer(c_int), intent(inout) :: p(*), i(*)
      real(c_double), intent(inout) :: x(*)
      real(c_double), intent(inout), optional :: length(*)
      integer(c_int), intent(inout) :: columns
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_weighting_face(order, nodes_s, s, candidate_s, nodes_t, t, candidate_t, p, i, x, &
        area, columns, error) bind(c) result(status)
      import :: c_int, c_double, dls_error
      integer(c_int), value :: order, nodes_s, nodes_t
      real(c_double), intent(in) :: s(*), t(*)
      integer(c_int), intent(in), optional :: candidate_s(*), candidate_t(*)
      integer(c_int), intent(inout) :: p(*), i(*)
      real(c_double), intent(inout) :: x(*)
      real(c_double), intent(inout), optional :: area(*)
      integer(c_int), intent(inout) :: columns
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function

    function dls_reduction_move(reduction, model, g, error) bind(c) result(status)
      import :: c_int, c_ptr, c_double, dls_model, dls_error
      type(c_ptr), value :: reduction
      type(dls_model), intent(in) :: model
      real(c_double), intent(in), optional :: g(*)
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function

    ! ---- pairs.h, rigid.h ----
    function dls_pairs_find(surfaces, pairs, error) bind(c) result(status)
      import :: c_int, dls_surfaces, dls_pairs, dls_error
      type(dls_surfaces), intent(in) :: surfaces
      type(dls_pairs), intent(inout) :: pairs
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    subroutine dls_pairs_free(pairs) bind(c)
      import :: dls_pairs
      type(dls_pairs), intent(inout) :: pairs
    end subroutine
    function dls_rigid_contact(count, bodies, a, b, point, normal, gap, k, body, H, q, frame, error) &
        bind(c) result(status)
      import :: c_int, c_double, dls_rigid, dls_error
      integer(c_int), value :: count, a, b, k  ! bodies and contacts from 0
      type(dls_rigid), intent(in) :: bodies(*)
      real(c_double), intent(in) :: point(3), normal(3)
      real(c_double), value :: gap
      integer(c_int), intent(inout) :: body(*)
      real(c_double), intent(inout) :: H(*), q(*)
      real(c_double), intent(inout), optional :: frame(9)
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_rigid_apply(count, bodies, nc, body, H, r, error) bind(c) result(status)
      import :: c_int, c_double, dls_rigid, dls_error
      integer(c_int), value :: count, nc
      type(dls_rigid), intent(inout) :: bodies(*)
      integer(c_int), intent(in) :: body(*)
      real(c_double), intent(in) :: H(*), r(*)
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function

    ! ---- motion.h ----
    subroutine dls_motion_settings_init(settings) bind(c)
      import :: dls_motion_settings
      type(dls_motion_settings), intent(inout) :: settings
    end subroutine
    function dls_motion_create(motion, model, settings, error) bind(c) result(status)
      import :: c_int, c_ptr, dls_motion_model, dls_motion_settings, dls_error
      type(c_ptr), intent(out) :: motion
      type(dls_motion_model), intent(in) :: model
      type(dls_motion_settings), intent(in) :: settings
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_motion_start(motion, x, v, t, error) bind(c) result(status)
      import :: c_int, c_ptr, c_double, dls_error
      type(c_ptr), value :: motion
      real(c_double), intent(in), optional :: x(*), v(*)
      real(c_double), value :: t
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_motion_step(motion, f, y, mu, info, error) bind(c) result(status)
      import :: c_int, c_ptr, c_double, dls_info, dls_error
      type(c_ptr), value :: motion
      real(c_double), intent(in), optional :: f(*), y(*), mu(*)
      type(dls_info), intent(inout), optional :: info
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_motion_set_h(motion, h, error) bind(c) result(status)
      import :: c_int, c_ptr, c_double, dls_error
      type(c_ptr), value :: motion
      real(c_double), value :: h
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_motion_get_state(motion, state, error) bind(c) result(status)
      import :: c_int, c_ptr, dls_motion_state, dls_error
      type(c_ptr), value :: motion
      type(dls_motion_state), intent(inout) :: state
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    function dls_motion_get_energies(motion, energies, error) bind(c) result(status)
      import :: c_int, c_ptr, dls_motion_energies, dls_error
      type(c_ptr), value :: motion
      type(dls_motion_energies), intent(inout) :: energies
      type(dls_error), intent(inout), optional :: error
      integer(c_int) :: status
    end function
    subroutine dls_motion_destroy(motion) bind(c)
      import :: c_ptr
      type(c_ptr), value :: motion
    end subroutine
  end interface
  public :: dls_version, dls_status_name, dls_status_text, dls_contact_check, dls_contact_certify, &
      dls_contact_fold
  public :: dls_certificate_holds, dls_contact_states, dls_solver_settings_init, dls_method_find
  public :: dls_solve, dls_solve_model, dls_solved, dls_solver_create, dls_solver_set_limits, dls_solver_solve
  public :: dls_solver_map
  public :: dls_solver_destroy, dls_reduction_settings_init, dls_reduction_create
  public :: dls_reduction_update, dls_reduction_get_info
  public :: dls_reduction_load, dls_reduction_load_free, dls_reduction_contact
  public :: dls_reduction_recover, dls_reduction_nodal, dls_reduction_states, dls_reduction_motion
  public :: dls_reduction_certify, dls_reduction_solve, dls_certificate_verdict
  public :: dls_limit_settings_init, dls_limit_load
  public :: dls_reduction_destroy, dls_weighting_line, dls_weighting_quadratic, &
      dls_weighting_face
  public :: dls_reduction_move, dls_pairs_find, dls_pairs_free, dls_rigid_contact, dls_rigid_apply
  public :: dls_motion_settings_init
  public :: dls_motion_create, dls_motion_start, dls_motion_step, dls_motion_set_h
  public :: dls_motion_get_state, dls_motion_get_energies, dls_motion_destroy
  public :: c_int, c_double, c_ptr, c_funptr, c_loc, c_funloc, c_null_ptr, c_null_char, c_f_pointer

contains

  ! Views a matrix. It has to be contiguous, and to live as long as the view.
  function dls_dense_of(A) result(view)
    real(c_double), intent(in), target, contiguous :: A(:, :)
    type(dls_dense) :: view
    view%rows = size(A, 1)
    view%cols = size(A, 2)
    view%ld = max(1, view%rows)
    if (size(A) > 0) view%a = c_loc(A)
  end function

  ! Views compressed columns: those of column j are p(j)+1 .. p(j+1); p and the rows i count from 0.
  function dls_sparse_of(rows, p, i, x) result(view)
    integer(c_int), intent(in) :: rows
    integer(c_int), intent(in), target, contiguous :: p(:), i(:)
    real(c_double), intent(in), target, contiguous :: x(:)
    type(dls_sparse) :: view
    view%rows = rows
    view%cols = size(p) - 1
    view%p = c_loc(p)
    view%i = c_loc(i)
    view%x = c_loc(x)
  end function

  ! Returns the message of an error.
  function dls_message(error) result(text)
    type(dls_error), intent(in) :: error
    character(:), allocatable :: text
    integer :: n
    n = 0
    do while (n < size(error%message))
      if (error%message(n + 1) == c_null_char) exit
      n = n + 1
    end do
    allocate (character(n) :: text)
    text = transfer(error%message(1:n), text)
  end function

  ! Returns a static text of the library: dls_text(dls_status_text(status)).
  function dls_text(address) result(text)
    type(c_ptr), intent(in) :: address
    character(:), allocatable :: text
    character(kind=c_char), dimension(:), pointer :: c
    integer :: n
    text = ''
    if (.not. c_associated(address)) return
    call c_f_pointer(address, c, [ishft(huge(n), -1)])
    n = 0
    do while (c(n + 1) /= c_null_char)
      n = n + 1
      text = text // c(n)
    end do
  end function

end module delassus
