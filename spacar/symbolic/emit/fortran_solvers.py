"""Fortran text of what solves for accelerations, as the C in `c.py` and `solvers.py`, which has the method."""

SIZES = """\
  integer, parameter :: n_q = {nq}, n_s = {n}, n_y = {ny}, n_g = {nm}  ! coordinates, speeds, state, constraints
"""

LDL = """\
  ! L D L^T without pivoting, mass overwritten; k columns of b become the solution
  function solve(mass, b, k) result(bad)
    integer, intent(in) :: k
    real(dp), intent(inout) :: mass(n_s, n_s), b(k, n_s)
    integer(c_int) :: bad
    integer :: i, j, l
    bad = 0
    do j = 1, n_s
      do l = 1, j - 1
        mass(j, j) = mass(j, j) - mass(j, l)*mass(j, l)*mass(l, l)
      end do
      if (.not. mass(j, j) > 0.0_dp) then
        bad = j
        return
      end if
      do i = j + 1, n_s
        do l = 1, j - 1
          mass(i, j) = mass(i, j) - mass(i, l)*mass(l, l)*mass(j, l)
        end do
        mass(i, j) = mass(i, j)/mass(j, j)
      end do
    end do
    do i = 1, n_s
      do l = 1, i - 1
        b(:, i) = b(:, i) - mass(i, l)*b(:, l)
      end do
    end do
    do i = n_s, 1, -1
      b(:, i) = b(:, i)/mass(i, i)
      do l = i + 1, n_s
        b(:, i) = b(:, i) - mass(l, i)*b(:, l)
      end do
    end do
  end function solve
"""

CONSTRAINED = """\
  ! M a - J^T l = b, J a = -h for k columns; b becomes a, h becomes l. mass and rows are overwritten.
  ! Dependent speeds are chosen by pivoting. j when the pivot of speed j is not positive, -1 when the constraints
  ! depend on each other.
  function constrained(mass, rows, b, h, k) result(bad)
    integer, intent(in) :: k
    real(dp), intent(inout) :: mass(n_s, n_s), rows(n_s, n_g), b(k, n_s), h(k, n_g)
    integer(c_int) :: bad
    real(dp) :: d(n_s), e(n_g, n_g), w(n_s, n_g), a(n_s, n_s), x(n_s), v(n_s), s(n_s), r(n_g), best, by, factor
    integer :: pivot(n_g), kept(n_s), nk, i, j, l, q, at, column
    logical :: done(n_g), dependent(n_s)
    bad = -1
    e = 0.0_dp
    done = .false.
    dependent = .false.
    do i = 1, n_s
      d(i) = 1.0_dp
      if (mass(i, i) > 0.0_dp) d(i) = 1.0_dp/sqrt(mass(i, i))
    end do
    do i = 1, n_s
      mass(:, i) = mass(:, i)*d*d(i)
      b(:, i) = b(:, i)*d(i)
    end do
    do l = 1, n_g
      rows(:, l) = rows(:, l)*d
      best = maxval(abs(rows(:, l)))
      if (.not. best > 0.0_dp) return
      w(:, l) = rows(:, l)/best
      e(l, l) = 1.0_dp/best
    end do
    do q = 1, n_g
      best = 8.0_dp*n_s*2.3e-16_dp
      at = 0
      column = 0
      do l = 1, n_g
        if (done(l)) cycle
        do j = 1, n_s
          if (.not. dependent(j) .and. abs(w(j, l)) > best) then
            best = abs(w(j, l))
            at = l
            column = j
          end if
        end do
      end do
      if (at == 0) return
      done(at) = .true.
      dependent(column) = .true.
      pivot(at) = column
      by = w(column, at)
      w(:, at) = w(:, at)/by
      e(:, at) = e(:, at)/by
      do l = 1, n_g
        factor = w(column, l)
        if (l == at) cycle
        w(:, l) = w(:, l) - factor*w(:, at)
        e(:, l) = e(:, l) - factor*e(:, at)
      end do
    end do
    nk = 0
    do i = 1, n_s
      if (.not. dependent(i)) then
        nk = nk + 1
        kept(nk) = i
      end if
    end do
    do i = 1, nk
      x = mass(:, kept(i)) - matmul(mass(:, pivot), w(kept(i), :))
      do j = 1, nk
        a(j, i) = x(kept(j)) - dot_product(w(kept(j), :), x(pivot))
      end do
    end do
    do j = 1, nk
      do q = 1, j - 1
        a(j, j) = a(j, j) - a(j, q)*a(j, q)*a(q, q)
      end do
      if (.not. a(j, j) > 0.0_dp) then
        bad = kept(j)
        return
      end if
      do i = j + 1, nk
        do q = 1, j - 1
          a(i, j) = a(i, j) - a(i, q)*a(q, q)*a(j, q)
        end do
        a(i, j) = a(i, j)/a(j, j)
      end do
    end do
    do l = 1, k
      s = 0.0_dp
      do q = 1, n_g
        s(pivot(q)) = s(pivot(q)) - dot_product(e(:, q), h(l, :))
      end do
      x = b(l, :) - matmul(mass, s)
      do i = 1, nk
        v(i) = x(kept(i)) - dot_product(w(kept(i), :), x(pivot))
        do q = 1, i - 1
          v(i) = v(i) - a(i, q)*v(q)
        end do
      end do
      do i = nk, 1, -1
        v(i) = v(i)/a(i, i)
        do q = i + 1, nk
          v(i) = v(i) - a(q, i)*v(q)
        end do
      end do
      do i = 1, nk
        s(kept(i)) = s(kept(i)) + v(i)
        do q = 1, n_g
          s(pivot(q)) = s(pivot(q)) - w(kept(i), q)*v(i)
        end do
      end do
      do q = 1, n_g
        r(q) = dot_product(mass(:, pivot(q)), s) - b(l, pivot(q))
      end do
      h(l, :) = matmul(e, r)
      b(l, :) = d*s
    end do
    bad = 0
  end function constrained
"""

RHS = """\
  ! accelerations and constraint forces a; 0, j when the pivot of speed j is not positive, -1 for dependent constraints
  function accelerations(c, p, y, u, a) result(bad)
    real(dp), intent(in) :: c(*), p(*), y(*), u(*)
    real(dp), intent(inout) :: a(n_s + n_g)
    integer(c_int) :: bad
    real(dp) :: mass(n_s*n_s){arrays}
    call eom_step(c, p, y, u, mass, a{filled})
    bad = {solve}
{moved}  end function accelerations

  ! inputs without a law are taken from u, the others are computed
  function rhs(t, c, p, y, u, ydot) result(bad) bind(c)
    real(dp), intent(in), value :: t
    real(dp), intent(in) :: c(*), p(*), y(*)
    real(dp), intent(inout) :: u(*), ydot(n_y)
    integer(c_int) :: bad
    real(dp) :: a(n_s + n_g)
    call eom_feed(t, c, p, y, u)
    call eom_rates(c, p, y, u, ydot)
    bad = accelerations(c, p, y, u, a)
    ydot(n_q + 1:) = a(1:n_s)
  end function rhs

  ! the named outputs
  function outputs(t, c, p, y, u, out) result(bad) bind(c)
    real(dp), intent(in), value :: t
    real(dp), intent(in) :: c(*), p(*), y(*)
    real(dp), intent(inout) :: u(*), out(*)
    integer(c_int) :: bad
{outputs}  end function outputs
"""

JAC = """\
  ! d(ydot)/dy, row by row
  function jac(t, c, p, y, u, J) result(bad) bind(c)
    real(dp), intent(in), value :: t
    real(dp), intent(in) :: c(*), p(*), y(*)
    real(dp), intent(inout) :: u(*), J(n_y*n_y)
    integer(c_int) :: bad
    real(dp) :: mass(n_s*n_s), a(n_s + n_g), slopes((n_y + n_g)*n_y){arrays}
    call eom_feed(t, c, p, y, u)
    bad = accelerations(c, p, y, u, a)
    if (bad /= 0) return
    call eom_slopes(t, c, p, y, u, a, slopes)
    call eom_step(c, p, y, u, mass, a{filled})
    bad = {solve}
    J = slopes(1:n_y*n_y)
  end function jac
"""
