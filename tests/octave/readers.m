% Reads a results file with both readers of corpus/matlab.
%
%   octave-cli readers.m RESULTS NAMES OUT
%
% NAMES holds one entity name per line. OUT gets, for each of them, a line "name columns rows", the rows of the quasi-static
% steps as read_kc gives them, and the same rows as read_xrf gives them.
arguments_ = argv();
addpath(fullfile(fileparts(mfilename('fullpath')), '..', '..', 'corpus', 'matlab'));
in = fopen(arguments_{2}, 'r');
names = {};
line = fgetl(in);
while ischar(line)
    names{end + 1} = line;
    line = fgetl(in);
end
fclose(in);
curves = read_kc(arguments_{1}, names);
x = read_xrf(arguments_{1});
out = fopen(arguments_{3}, 'w');
for k = 1:length(names)
    first = find(strcmp({x.entity.name}, names{k}));
    rows = x.data(x.equilibrium, x.entity(first(1)).column);
    [n, m] = size(curves{k});
    fprintf(out, '%s %d %d\n', names{k}, m, n);
    fprintf(out, [repmat(' %.17g', 1, m) '\n'], curves{k}');
    fprintf(out, [repmat(' %.17g', 1, m) '\n'], rows');
end
fclose(out);
