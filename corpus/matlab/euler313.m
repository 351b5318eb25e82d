function R = euler313(angles)
%EULER313  Rotation matrix of the body 3-1-3 angles PSI THETA PHI (radians), as in REULER and in the results of ADAMS.

c = cos(angles);
s = sin(angles);
R = [c(1) -s(1) 0; s(1) c(1) 0; 0 0 1]*[1 0 0; 0 c(2) -s(2); 0 s(2) c(2)]*[c(3) -s(3) 0; s(3) c(3) 0; 0 0 1];
