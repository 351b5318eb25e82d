function curves = read_kc(file, names)
%READ_KC  Curves of a kinematics and compliance run, read line by line.
%
%   curves = read_kc('kc.res', {'time', 'wheel_travel'}) gives one matrix per name: a row per equilibrium of the run, a column
%   per component of the first entity with that name.
%
%   The quick way many post-processors go, without looking at the structure of the file: after the line with <Entity name="...">
%   the numbers id="..." of the lines below, then, after each line with "quasiStatic" or "static", the numbers of the lines below up to the
%   first line that is not made of numbers.

in = fopen(file, 'r');
if in < 0
    error('read_kc: cannot open %s', file);
end
ids = cell(1, length(names));
curves = cell(1, length(names));
line = fgetl(in);
while ischar(line)
    here = 0;
    for k = 1:length(names)
        if isempty(ids{k}) && ~isempty(strfind(line, ['<Entity name="' names{k} '"']))
            here = k;
        end
    end
    if here > 0
        line = fgetl(in);
        while ischar(line)
            id = regexp(line, 'id="(\d+)"', 'tokens', 'once');
            if isempty(id)
                break
            end
            ids{here}(end+1) = str2double(id{1});
            line = fgetl(in);
        end
    elseif ~isempty(strfind(line, '"quasiStatic"')) || ~isempty(strfind(line, '"static"'))
        values = [];
        line = fgetl(in);
        while ischar(line)
            numbers = sscanf(line, '%f');
            if isempty(numbers)
                break
            end
            values = [values; numbers];
            line = fgetl(in);
        end
        for k = 1:length(names)
            curves{k}(end+1, :) = values(ids{k})';
        end
    else
        line = fgetl(in);
    end
end
fclose(in);
for k = 1:length(names)
    if isempty(ids{k})
        error('read_kc: no entity "%s" in %s', names{k}, file);
    end
end
