function delta = bushing_deflection(A_I, A_J)
%BUSHING_DEFLECTION  The six deflections of a bushing.
%
%   delta = bushing_deflection(A_I, A_J) is [x y z ax ay az] of marker I in the axes of marker J, from the poses of both (4x4
%   operators [R p; 0 0 0 1]); angles in radians. Equations (4) to (6) of the paper, which are the DX DY DZ and AX AY AZ of the
%   BUSHING statement.

D = A_J\A_I;
a = D(1:3, 1:3);
delta = [D(1:3, 4)', atan2(-a(2, 3), a(3, 3)), atan2(a(1, 3), a(3, 3)), atan2(a(2, 1), a(1, 1))];
