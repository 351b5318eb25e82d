function x = read_xrf(file)
%READ_XRF  Reads an ADAMS results file (.res, XRF form).
%
%   x = read_xrf('run.res') gives
%     x.data          one row per step of the file, one column per component
%     x.column        column of a component by name: x.data(:, x.column.KNUCKLE_XFORM.Z)
%     x.step          kind of each row: 'input', 'quasiStatic', 'static', 'initialConditions', 'dynamic' ...
%     x.equilibrium   rows that are static equilibria: x.data(x.equilibrium, x.column.time.TIME)
%     x.entity        every entity in the order of the file: name, object, type, id, component, unit, column
%     x.units         units of the file: angle, length, mass, time
%
%   Characters that no MATLAB name can hold become '_' in x.column, and of two entities with one name the second gets '_2'. A
%   file whose run was killed gives the steps that are complete.

in = fopen(file, 'r');
if in < 0
    error('read_xrf: cannot open %s', file);
end
x.data = [];
x.column = struct;
x.step = {};
x.equilibrium = [];
x.entity = struct('name', {}, 'object', {}, 'type', {}, 'id', {}, 'component', {}, 'unit', {}, 'column', {});
x.units = struct('angle', 'rad', 'length', '', 'mass', '', 'time', '');
values = {};
numbers = [];
kind = '';
line = fgetl(in);
while ischar(line)
    if isempty(line) || line(1) ~= '<'
        if ~isempty(kind)
            numbers = [numbers; sscanf(line, '%f')];
        end
    elseif strncmp(line, '<Step ', 6)
        kind = attribute(line, 'type');
        numbers = [];
    elseif strncmp(line, '</Step>', 7)
        x.step{end+1, 1} = kind;
        values{end+1, 1} = numbers;
        kind = '';
    elseif strncmp(line, '<Entity ', 8)
        e = struct('name', attribute(line, 'name'), 'object', attribute(line, 'entity'), ...
            'type', attribute(line, 'entType'), 'id', str2double(attribute(line, 'objectId')), ...
            'component', {{}}, 'unit', {{}}, 'column', []);
    elseif strncmp(line, '<Component ', 11)
        e.component{end+1} = attribute(line, 'name');
        e.unit{end+1} = attribute(line, 'unitsValue');
        e.column(end+1) = str2double(attribute(line, 'id'));
    elseif strncmp(line, '</Entity>', 9)
        x.entity(end+1) = e;
    elseif strncmp(line, '<Units ', 7)
        names = fieldnames(x.units);
        for k = 1:length(names)
            x.units.(names{k}) = attribute(line, names{k});
        end
    end
    line = fgetl(in);
end
fclose(in);

width = max([x.entity.column, 0]);
x.data = NaN*ones(length(values), width);
for k = 1:length(values)
    n = min(width, length(values{k}));
    x.data(k, 1:n) = values{k}(1:n)';
end
x.equilibrium = strcmp(x.step, 'quasiStatic') | strcmp(x.step, 'static') | strcmp(x.step, 'equilibrium');
for k = 1:length(x.entity)
    e = x.entity(k);
    columns = struct;
    for c = 1:length(e.component)
        columns.(free_name(columns, e.component{c})) = e.column(c);
    end
    x.column.(free_name(x.column, e.name)) = columns;
end

% -------------------------------------------------------------------------------------------------------------------------------
function value = attribute(line, name)
% The text of name="..." in a tag, '' where there is none.
value = '';
found = regexp(line, [' ' name '="([^"]*)"'], 'tokens', 'once');
if ~isempty(found)
    value = found{1};
    if any(value == '&')
        value = strrep(strrep(strrep(value, '&lt;', '<'), '&gt;', '>'), '&quot;', '"');
        value = strrep(strrep(value, '&apos;', ''''), '&amp;', '&');
    end
end

% -------------------------------------------------------------------------------------------------------------------------------
function name = free_name(taken, name)
% A field name like the text that the structure does not have yet.
if isempty(name)
    name = 'unnamed';
end
name(~(isletter(name) | (name >= '0' & name <= '9'))) = '_';
if ~isletter(name(1))
    name = ['x' name];
end
stem = name(1:min(length(name), 55));
name = stem;
k = 1;
while isfield(taken, name)
    k = k + 1;
    name = sprintf('%s_%d', stem, k);
end
