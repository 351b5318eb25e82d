function A = absolute_orientation(p_part, p_ground)
%ABSOLUTE_ORIENTATION  The pose of a part from marks on it.
%
%   A = absolute_orientation(p_part, p_ground) is the 4x4 operator [R p; 0 0 0 1] that brings the marks P_PART (3 x n, in the
%   axes of the part) closest to P_GROUND (3 x n, as measured), equation (3) of the paper. Singular value decomposition, after
%   K. S. Arun, T. S. Huang, S. D. Blostein, "Least-squares fitting of two 3-D point sets", 1987.

n = size(p_part, 2);
c_part = mean(p_part, 2);
c_ground = mean(p_ground, 2);
H = (p_part - repmat(c_part, 1, n))*(p_ground - repmat(c_ground, 1, n))';
[U, S, V] = svd(H);
if S(2, 2) < 1e-9*S(1, 1)
    error('absolute_orientation: the marks lie on one line');
end
R = V*diag([1 1 det(V*U')])*U';  % a rotation, never a reflection
A = [R, c_ground - R*c_part; 0 0 0 1];
