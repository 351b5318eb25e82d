function [header, rows] = csv_cells(file)
%CSV_CELLS  The words of a CSV file.
%
%   [header, rows] = csv_cells(file): the words of the first line, and those of every other line (cell array, one row per line).
%   Lines that start with # and empty lines are left out; line ends of Windows and Unix alike.

in = fopen(file, 'r');
if in < 0
    error('csv_cells: cannot open %s', file);
end
header = {};
rows = {};
n = 0;
line = fgetl(in);
while ischar(line)
    line = strtrim(line);
    if ~isempty(line) && line(1) ~= '#'
        commas = [0, find(line == ','), length(line) + 1];
        words = cell(1, length(commas) - 1);
        for k = 1:length(words)
            words{k} = strtrim(line(commas(k)+1:commas(k+1)-1));
        end
        if isempty(header)
            header = words;
        else
            n = n + 1;
            rows(n, 1:length(words)) = words;
        end
    end
    line = fgetl(in);
end
fclose(in);
