% Runs corpus/matlab/identify_bushings.m as a user would, with `mdi` on the PATH.
%
%   octave-cli identify.m STUDY WORK [NAME VALUE]...
%
% Writes WORK/identified.txt: the number of iterations, then one line per bushing.
arguments_ = argv();
addpath(fullfile(fileparts(mfilename('fullpath')), '..', '..', 'corpus', 'matlab'));
work = arguments_{2};
settings = struct;
for k = 3:2:length(arguments_)
    settings.(arguments_{k}) = str2num(arguments_{k + 1});
end
[K, history] = identify_bushings(arguments_{1}, work, settings);
out = fopen(fullfile(work, 'identified.txt'), 'w');
fprintf(out, '%d\n', size(history, 3));
fprintf(out, '%.17g %.17g %.17g %.17g %.17g %.17g\n', K');
fclose(out);
