! test_fortran.f90: delassus.f90: types as C has them, optional arguments, callbacks both ways,
! errors, motion.
module callbacks
  use, intrinsic :: iso_c_binding, only: c_associated
  use delassus
  implicit none
  integer :: calls = 0
contains
  ! Counts the calls of a solve; stops it where data is given.
  function watch(data, progress) bind(c) result(stop)
    type(c_ptr), value :: data
    type(dls_progress), intent(in) :: progress
    integer(c_int) :: stop
    calls = calls + 1
    stop = 0
    if (c_associated(data) .and. progress%last == 0) stop = 1
  end function
  ! Solves with K = (3 1; 1 2).
  function two_springs(user, X, n, nrhs) bind(c) result(failed)
    type(c_ptr), value :: user
    integer(c_int), value :: n, nrhs
    real(c_double), intent(inout) :: X(n, nrhs)
    integer(c_int) :: failed
    real(c_double) :: first(nrhs)
    failed = merge(0, 1, n == 2 .and. .not. c_associated(user))
    first = (2 * X(1, :) - X(2, :)) / 5
    X(2, :) = (3 * X(2, :) - X(1, :)) / 5
    X(1, :) = first
  end function
end module

program test_fortran
  use delassus
  use callbacks
  implicit none
  integer :: failures = 0

  call solves
  call calls_back
  call reduces
  call refuses
  call geometry
  call moves
  print '(2a)', 'Fortran: ', merge('failed', 'passed', failures > 0)
  if (failures > 0) stop 1

contains

  subroutine expect(good, text)
    logical, intent(in) :: good
    character(*), intent(in) :: text
    if (good) return
    print '(2a)', 'tests/languages/test_fortran.f90: not so: ', text
    failures = failures + 1
  end subroutine

  logical function near(a, b)
    real(c_double), intent(in) :: a, b
    near = abs(a - b) <= 1d-8 * abs(b)
  end function

  ! As examples/hello_contact.c.
  subroutine solves
    real(c_double), target :: W(2, 2), q(2), mu(1)
    real(c_double) :: r(2), u(2)
    integer(c_int) :: state(1), status
    type(dls_contact) :: problem
    type(dls_solver_settings) :: settings
    type(dls_info) :: info
    type(dls_certificate) :: certificate
    type(c_ptr) :: solver
    W = reshape([1d-3, 0d0, 0d0, 1d-3], [2, 2])
    q = [-2d-3, 3d-3]
    mu = 0.5d0
    problem%d = 2
    problem%nc = 1
    problem%W = dls_dense_of(W)
    problem%q = c_loc(q)
    problem%mu = c_loc(mu)
    call expect(dls_contact_check(problem) == DLS_OK, 'a sound problem')
    call expect(dls_solve(problem, r=r) == DLS_OK, 'a solve without the optional arguments')
    call expect(near(r(1), 2d0) .and. near(r(2), -1d0), 'r')
    call dls_solver_settings_init(settings)
    call expect(settings%limits%tol == 1d-8, 'tol of the defaults')
    call expect(dls_method_find('newton' // c_null_char, settings%method) == 1, &
        'a method by its name')
    call expect(settings%method == DLS_NEWTON, 'its number')
    r = 0
    status = dls_solve(problem, settings, r, u, info)
    call expect(status == DLS_OK .and. info%status == DLS_OK .and. info%method == DLS_NEWTON, &
        'newton')
    call expect(near(u(2), 2d-3) .and. info%certificate%residual <= 1d-8, &
        'u and the certificate of info')
    status = dls_contact_states(problem, r, u, state)
    call expect(status == DLS_OK .and. state(1) == DLS_SLIP, 'its state')
    status = dls_contact_certify(problem, [1d0, 0d0], certificate=certificate)
    call expect(status == DLS_OK .and. near(certificate%penetration, 1d-3), 'penetration')
    call expect(dls_certificate_holds(certificate, 1d-8) == 0, 'a wrong r')
    call expect(dls_solver_create(solver, 2, 1) == DLS_OK, 'a workspace')
    r = 0
    status = dls_solver_solve(solver, problem, r)
    call expect(status == DLS_OK .and. near(r(1), 2d0), 'a solve in it')
    settings%limits%tol = 1d-12
    call expect(dls_solver_set_limits(solver, settings%limits) == DLS_OK, 'other limits')
    r = 0
    call expect(dls_solver_map(solver, 1, [0], r) == DLS_OK .and. near(r(1), 2d0), 'its map')
    call dls_solver_destroy(solver)
    call expect(dls_text(dls_status_name(DLS_E_SIZE)) == 'DLS_E_SIZE', 'the name of a status')
    call expect(len(dls_text(dls_version())) > 0, 'the version')
  end subroutine

  ! A chain of 30 candidates that all couple, so that no method ends at once.
  subroutine calls_back
    integer, parameter :: nc = 30, m = 2 * nc
    real(c_double), target :: W(m, m), q(m), mu(nc)
    real(c_double) :: r(m)
    type(dls_contact) :: problem
    type(dls_solver_settings) :: settings
    integer :: i, j
    integer(c_int) :: status
    do j = 1, m
      do i = 1, m
        W(i, j) = min(i, j)
      end do
      q(j) = merge(0.5d0, -1d0 - mod(j, 7), mod(j, 2) == 0)
    end do
    mu = 0.4d0
    problem%d = 2
    problem%nc = nc
    problem%W = dls_dense_of(W)
    problem%q = c_loc(q)
    problem%mu = c_loc(mu)
    call dls_solver_settings_init(settings)
    settings%limits%progress = c_funloc(watch)
    status = dls_solve(problem, settings, r)
    call expect(status == DLS_OK .and. calls > 1, 'calls of a progress function')
    settings%limits%progress_data = c_loc(mu)
    call expect(dls_solve(problem, settings, r) == DLS_CANCELLED, 'a cancelled solve')
  end subroutine

  ! docs/tour.md, with the factorisation of the host.
  subroutine reduces
    real(c_double), target :: mu(1), one(1)
    integer(c_int), target :: p(2), along(1), up(1)
    integer(c_int) :: state(1)
    real(c_double) :: r(2), x(2), nodal(2)
    type(dls_model) :: model
    type(dls_contact) :: problem
    type(dls_reduction_info) :: info
    type(dls_limit_settings) :: settings
    type(dls_limit) :: limit
    type(dls_fold) :: fold
    type(c_ptr) :: reduction
    integer(c_int) :: status
    mu = 0.2d0
    one = 1
    p = [0, 1]
    along = 0
    up = 1
    model%d = 2
    model%n = 2
    model%nodes = 1
    model%operator_kind = DLS_HOST_SOLVER
    model%solve = c_funloc(two_springs)
    model%HN = dls_sparse_of(2, p, up, one)
    model%HT = dls_sparse_of(2, p, along, one)
    call expect(dls_reduction_create(reduction, model) == DLS_OK, &
        'a reduction by the host''s solver')
    call expect(dls_reduction_load(reduction, [5d0, -10d0]) == DLS_OK, 'loads')
    call expect(dls_reduction_contact(reduction, c_loc(mu), problem) == DLS_OK, &
        'the contact problem')
    status = dls_solve(problem, r=r)
    call expect(status == DLS_OK .and. near(r(1), 10.9375d0), 'its r')
    status = dls_reduction_recover(reduction, r, x)
    call expect(status == DLS_OK .and. near(x(1), 0.9375d0), 'x')
    status = dls_reduction_nodal(reduction, r, nodal)
    call expect(status == DLS_OK .and. all(nodal == r), 'nodal reactions')
    call expect(dls_solved(DLS_TO_ROUNDING) == 1 .and. dls_solved(DLS_STALLED) == 0, 'solved')
    call expect(dls_reduction_states(reduction, mu, r, [0d0, 0.9375d0], state) == DLS_OK .and. &
        state(1) == DLS_SLIP, 'states')
    call expect(.not. c_associated(dls_reduction_motion(reduction)), 'no motion')
    status = dls_contact_fold(problem, fold, q=x, r=r, other=nodal)
    call expect(status == DLS_OK .and. fold%exact == 1 .and. fold%unique == fold%friction, 'the fold')
    call dls_limit_settings_init(settings)
    settings%to = 3
    status = dls_limit_load(reduction, [5d0, -10d0], [0d0, -1d0], mu=mu, settings=settings, r=r, limit=limit)
    call expect(status == DLS_OK .and. limit%proved == 0 .and. limit%carried == 3, 'a held body carries')
    status = dls_reduction_get_info(reduction, info)
    call expect(status == DLS_OK .and. info%W_bytes == 32, 'info')
    call dls_reduction_destroy(reduction)
    call dls_reduction_destroy(c_null_ptr)
  end subroutine

  subroutine refuses
    real(c_double), target :: W(2, 2), q(2), mu(1)
    real(c_double) :: r(2)
    type(dls_contact) :: problem
    type(dls_error) :: error
    integer(c_int) :: status
    W = reshape([1d0, 0d0, 0d0, 1d0], [2, 2])
    q = [-1d0, 0d0]
    mu = -1
    problem%d = 2
    problem%nc = 1
    problem%W = dls_dense_of(W)
    problem%q = c_loc(q)
    problem%mu = c_loc(mu)
    r = 7
    status = dls_solve(problem, r=r, error=error)
    call expect(status == DLS_E_ARGUMENT .and. error%status == status, 'negative friction')
    call expect(dls_text(error%argument) == 'mu' .and. error%index == 0 .and. error%value == -1, &
        'its place')
    call expect(index(dls_message(error), 'dls_solve: mu[0]') == 1, 'its message')
    call expect(all(r == 7), 'outputs untouched')
  end subroutine

  ! A node over an edge: H and the gap. A ball thrown at the floor stops: its momentum is the impulse.
  subroutine geometry
    real(c_double), target :: X(6), H(36), q(3), r(3), mu(1)
    integer(c_int), target :: node(1), face(2), body(2)
    real(c_double), pointer :: gap(:)
    type(dls_surfaces) :: surfaces
    type(dls_pairs) :: pairs
    type(dls_rigid) :: ball(1)
    type(dls_contact) :: problem
    type(dls_error) :: error
    integer(c_int) :: status
    X = [0d0, 0d0, 4d0, 0d0, 1d0, 0.5d0]
    node = 3
    face = [2, 1]
    surfaces%d = 2
    surfaces%n = 6
    surfaces%points = 3
    surfaces%base = 1
    surfaces%X = c_loc(X)
    surfaces%nodes = 1
    surfaces%node = c_loc(node)
    surfaces%faces = 1
    surfaces%corners = 2
    surfaces%face = c_loc(face)
    status = dls_pairs_find(surfaces, pairs, error)
    call expect(status == DLS_OK .and. pairs%nodes == 1 .and. pairs%HN%rows == 6, 'pairs')
    call c_f_pointer(pairs%g, gap, [2])
    call expect(near(gap(1), 0.5d0), 'their gap')
    call dls_pairs_free(pairs)
    surfaces%corners = 3
    status = dls_pairs_find(surfaces, pairs, error)
    call expect(status == DLS_E_ARGUMENT .and. dls_text(error%argument) == 'corners', 'three corners')
    ball(1)%mass = 2
    ball(1)%inertia = [1d0, 0d0, 0d0, 0d0, 1d0, 0d0, 0d0, 0d0, 1d0]
    ball(1)%R = ball(1)%inertia
    ball(1)%x = [0d0, 0d0, 1d0]
    ball(1)%v = [0d0, 0d0, -3d0]
    status = dls_rigid_contact(1, ball, 0, -1, [0d0, 0d0, 0d0], [0d0, 0d0, 1d0], 0d0, 0, body, H, q)
    call expect(status == DLS_OK .and. near(q(1), -3d0) .and. body(2) == -1, 'a contact of a ball')
    mu = 0
    problem%d = 3
    problem%nc = 1
    problem%q = c_loc(q)
    problem%mu = c_loc(mu)
    problem%bodies%n = 6
    problem%bodies%count = 1
    problem%bodies%body = c_loc(body)
    problem%bodies%H = c_loc(H)
    call expect(dls_solve(problem, r=r) == DLS_OK .and. near(r(1), 6d0), 'its impulse')
    call expect(dls_rigid_apply(1, ball, 1, body, H, r) == DLS_OK, 'its motion')
    call expect(abs(ball(1)%v(3)) <= 1d-8, 'it has stopped')
  end subroutine

  ! A ball falls on a floor and rests: p is its weight times h.
  subroutine moves
    real(c_double), target :: ones(2), gap(1)
    integer(c_int), target :: p(3), rows(2), one_column(2), along(1), up(1)
    real(c_double), pointer :: impulse(:)
    type(dls_motion_model) :: model
    type(dls_motion_settings) :: settings
    type(dls_motion_state) :: state
    type(dls_motion_energies) :: energies
    type(dls_error) :: error
    type(c_ptr) :: motion
    integer :: k
    integer(c_int) :: status
    ones = 1
    gap = 0.05d0
    p = [0, 1, 2]
    rows = [0, 1]
    one_column = [0, 1]
    along = 0
    up = 1
    model%d = 2
    model%n = 2
    model%nodes = 1
    model%factorization = DLS_CHOLESKY
    model%M = dls_sparse_of(2, p, rows, ones)
    model%HN = dls_sparse_of(2, one_column, up, ones(1:1))
    model%HT = dls_sparse_of(2, one_column, along, ones(1:1))
    model%gap = c_loc(gap)
    call dls_motion_settings_init(settings)
    status = dls_motion_create(motion, model, settings, error)
    call expect(status == DLS_E_ARGUMENT .and. dls_text(error%argument) == 'h', 'a step of 0')
    settings%h = 0.01d0
    call expect(dls_motion_create(motion, model, settings, error) == DLS_OK, 'a motion')
    call expect(dls_motion_start(motion, t=1d0) == DLS_OK, 'a start')
    do k = 1, 40
      if (dls_motion_step(motion, [0d0, -10d0]) /= DLS_OK) failures = failures + 1
    end do
    status = dls_motion_get_state(motion, state)
    call expect(status == DLS_OK .and. state%steps == 40, 'its state')
    call c_f_pointer(state%p, impulse, [2])
    call expect(near(impulse(1), 0.1d0) .and. near(state%t, 1.4d0), 'the weight')
    call expect(dls_motion_get_energies(motion, energies) == DLS_OK, 'energies')
    call expect(abs(energies%residual) <= 1d-12 * energies%scale, 'their identity')
    call expect(dls_motion_set_h(motion, 0.02d0) == DLS_OK, 'another step')
    call dls_motion_destroy(motion)
  end subroutine

end program
